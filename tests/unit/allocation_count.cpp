// SPDX-License-Identifier: Apache-2.0
//
// Every form of operator new and delete: with some replaced, AddressSanitizer's others would not
// match.
#include "tests/allocation_count.hpp"

#include <cstdlib>
#include <new>

// clang's ThreadSanitizer brings operators of its own, and cannot do without: there nothing is
// counted, and only the cases tagged [tsan] run, none of which asks.
#if defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define AFTERGLOW_COUNTS_NOTHING
#endif
#endif

#ifdef AFTERGLOW_COUNTS_NOTHING

std::uint64_t allocation_count() {
    return 0;
}

#else

namespace {

using Size = std::size_t;
using Align = std::align_val_t;
using Nothrow = std::nothrow_t;

thread_local std::uint64_t allocations = 0;

void *allocate(Size size, Align alignment = Align{__STDCPP_DEFAULT_NEW_ALIGNMENT__}) noexcept {
    ++allocations;
    const auto align = static_cast<Size>(alignment);
    return std::aligned_alloc(align, (size + align) / align * align); // never of nothing
}

void *or_throw(void *memory) {
    return memory != nullptr ? memory : throw std::bad_alloc();
}

} // namespace

std::uint64_t allocation_count() {
    return allocations;
}

// clang-format off
void *operator new(Size size) { return or_throw(allocate(size)); }
void *operator new[](Size size) { return or_throw(allocate(size)); }
void *operator new(Size size, Align align) { return or_throw(allocate(size, align)); }
void *operator new[](Size size, Align align) { return or_throw(allocate(size, align)); }
void *operator new(Size size, const Nothrow &) noexcept { return allocate(size); }
void *operator new[](Size size, const Nothrow &) noexcept { return allocate(size); }
void *operator new(Size size, Align align, const Nothrow &) noexcept { return allocate(size, align); }
void *operator new[](Size size, Align align, const Nothrow &) noexcept { return allocate(size, align); }
void operator delete(void *memory) noexcept { std::free(memory); }
void operator delete[](void *memory) noexcept { std::free(memory); }
void operator delete(void *memory, Size) noexcept { std::free(memory); }
void operator delete[](void *memory, Size) noexcept { std::free(memory); }
void operator delete(void *memory, Align) noexcept { std::free(memory); }
void operator delete[](void *memory, Align) noexcept { std::free(memory); }
void operator delete(void *memory, Size, Align) noexcept { std::free(memory); }
void operator delete[](void *memory, Size, Align) noexcept { std::free(memory); }
// clang-format on

#endif
