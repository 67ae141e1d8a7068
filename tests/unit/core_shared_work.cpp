// SPDX-License-Identifier: Apache-2.0
//
// A file of its own, so that ThreadSanitizer sees what workers share of a frame.
#include "tests/catch.hpp"
#include "tests/film.hpp"

#include <vector>

using namespace afterglow;
using namespace afterglow::testing;

TEST_CASE("the keyframe estimate is identical for any number of workers", "[core][tsan]") {
    constexpr int frames = 9;
    const Film film = film_room(320, 240, frames, 2);
    const auto run = [&](int workers) {
        Viewer viewer(film, {}, workers);
        std::vector<unsigned char> bits;
        const auto note = [&](const Estimate &e) {
            const auto add = [&](const void *data, std::size_t size) {
                const auto *bytes = static_cast<const unsigned char *>(data);
                bits.insert(bits.end(), bytes, bytes + size);
            };
            add(e.depth.data(), sizeof(std::uint16_t) * 320 * 240);
            add(e.confidence.data(), 320 * 240);
            add(e.pose.R.data(), sizeof e.pose.R);
            add(e.pose.T.data(), sizeof e.pose.T);
            add(&e.expected_mre, sizeof e.expected_mre);
            add(&e.coverage, sizeof e.coverage);
        };
        for (int k = 0; k < frames; ++k) {
            note(viewer.track(k));
            if (k % 4 == 0)
                note(viewer.measure(k));
        }
        return bits;
    };
    const auto alone = run(1);
    CHECK(run(2) == alone);
    CHECK(run(5) == alone);
}
