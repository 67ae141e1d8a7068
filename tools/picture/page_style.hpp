// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace afterglow {

/// The style sheet of pages with tables, plots and pictures.
inline constexpr const char *page_style = R"(
:root { color-scheme: light dark; --ink: #1c2024; --soft: #5f6872; --paper: #fff; --line: #dfe3e7;
  --stripe: #f6f7f8; --theirs: #8a4b08;
  --c0: #1f6fb5; --c1: #d62828; --c2: #2a9134; --c3: #8e44ad; --c4: #b8860b; --c5: #7a8288;
  --c6: #a9714b; --c7: #c2579b; --c8: #0f9b9b; --c9: #5d6d2e; --c10: #44518c; --c11: #000000;
  --c12: #888f96; --c13: #8a4b08; }
@media (prefers-color-scheme: dark) { :root { --ink: #e4e7ea; --soft: #9aa4ae; --paper: #14171a;
  --line: #30363c; --stripe: #1b1f23; --theirs: #e6ac6c;
  --c0: #64b0f4; --c1: #ff6b6b; --c2: #63cf6e; --c3: #c58be0; --c4: #e6c04a; --c5: #a5adb4;
  --c6: #d8a27d; --c7: #f08fc8; --c8: #4fd3d3; --c9: #b0c26a; --c10: #93a2ea; --c11: #ffffff;
  --c12: #8a939b; --c13: #e6ac6c; } }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 1.5rem clamp(.8rem, 3vw, 2.5rem) 4rem; max-width: 84rem;
  background: var(--paper); color: var(--ink); font: 16px/1.5 system-ui, sans-serif; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: 0 0 .4rem; }
h2 { font-size: 1.15rem; margin: 2.6rem 0 .3rem; }
p { max-width: 46rem; margin: .3rem 0 .8rem; color: var(--soft); }
nav { margin: 1rem 0; font-size: .9rem; display: flex; flex-wrap: wrap; gap: .2rem 1rem; }
a { color: var(--c0); text-decoration: none; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: .88rem; font-variant-numeric: tabular-nums; }
th, td { padding: .3rem .7rem; text-align: right; white-space: nowrap;
  border-bottom: 1px solid var(--line); }
th { font-weight: 600; }
thead th { white-space: normal; vertical-align: bottom; min-width: 4.5rem; }
th:first-child { text-align: left; position: sticky; left: 0; background: var(--paper); }
th:first-child { overflow-wrap: anywhere; }
@media (max-width: 40rem) { th:first-child, .many th:first-child { white-space: normal;
  min-width: 6.5rem; max-width: 34vw; font-size: .92em; } th, td { padding: .3rem .45rem; } }
tbody tr:hover td, tbody tr:hover th { background: var(--stripe); }
tbody { border-bottom: 1px solid var(--line); }
tbody th, tbody td { vertical-align: top; }
.many { font-size: .8rem; }
.many th, .many td { padding: .25rem .35rem; }
.many thead th { min-width: 3.6rem; }
.many th:first-child { white-space: normal; min-width: 9rem; }
.theirs { color: var(--theirs); font-size: .86em; margin-left: .35em; }
.many .theirs { display: block; margin: 0; }
.origin { font-size: .88rem; }
.partial { border-left: 4px solid var(--c1); padding-left: .8rem; color: var(--ink); }
.panels { display: grid; gap: 1rem; grid-template-columns: repeat(auto-fill, minmax(min(100%, 24rem), 1fr)); }
svg { width: 100%; height: auto; max-width: 36rem; }
svg text { fill: var(--soft); font: 11px system-ui, sans-serif; }
svg .title { fill: var(--ink); font-size: 13px; font-weight: 600; }
svg .grid { stroke: var(--line); fill: none; }
svg .line { fill: none; stroke: var(--c); stroke-width: 1.8; stroke-linejoin: round; }
svg circle { fill: var(--c); }
svg .outside { fill: none; stroke: var(--c); }
svg .dashed .line { stroke-dasharray: 6 4; }
svg rect { fill: var(--c); }
svg .inside { fill: var(--paper); font-weight: 600; }
.legend { list-style: none; display: flex; flex-wrap: wrap; gap: .2rem 1.2rem; padding: 0;
  margin: .2rem 0 .8rem; font-size: .88rem; }
.legend li::before { content: ""; display: inline-block; width: .8em; height: .8em; margin-right: .4em;
  border-radius: 50%; background: var(--c); }
.legend .dashed::before { background: none; border: 2px dashed var(--c); }
.c0 { --c: var(--c0); } .c1 { --c: var(--c1); } .c2 { --c: var(--c2); } .c3 { --c: var(--c3); }
.c4 { --c: var(--c4); } .c5 { --c: var(--c5); } .c6 { --c: var(--c6); } .c7 { --c: var(--c7); }
.c8 { --c: var(--c8); } .c9 { --c: var(--c9); } .c10 { --c: var(--c10); } .c11 { --c: var(--c11); }
.c12 { --c: var(--c12); } .c13 { --c: var(--c13); }
.pictures { display: grid; gap: .6rem; margin-bottom: 1.4rem;
  grid-template-columns: repeat(auto-fill, minmax(min(46%, 11.5rem), 1fr)); }
h3 { font-size: 1rem; margin: 1rem 0 .3rem; overflow-wrap: anywhere; }
figure { margin: 0; }
figure img { width: 100%; display: block; border-radius: 3px; }
.bar { display: flex; align-items: center; gap: .4em; font-size: .75rem; white-space: nowrap;
  color: var(--soft); margin-top: .25rem; }
.bar i { flex: 1; height: .55rem; border-radius: 2px; }
figcaption { font-size: .82rem; color: var(--soft); }
@media print { nav { display: none; } h2 { break-after: avoid; } }
)";

} // namespace afterglow
