// SPDX-License-Identifier: Apache-2.0
//
// Without a sanitizer the allocation functions of glibc are replaced by ones that count and then
// call glibc's. A sanitizer has replaced them already, and calls a hook for each allocation.
#include "tests/allocation_count.hpp"

#include "tests/catch.hpp"
#include "tests/sanitized.hpp"

#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <functional>
#include <malloc.h>
#include <memory>
#include <new>
#include <string>
#include <thread>

namespace {

// Constant initialised: malloc runs before main.
std::atomic<std::uint64_t> allocations = 0;
thread_local std::uint64_t thread_allocations = 0;

void count_allocation() {
    ++allocations;
    ++thread_allocations;
}

} // namespace

std::uint64_t allocation_count() {
    return allocations;
}

std::uint64_t thread_allocation_count() {
    return thread_allocations;
}

#ifdef AFTERGLOW_SANITIZED

extern "C" int __sanitizer_install_malloc_and_free_hooks( // NOLINT(bugprone-reserved-identifier)
    void (*allocated)(const volatile void *, std::size_t), void (*freed)(const volatile void *));

namespace {

[[maybe_unused]] const int hooks = __sanitizer_install_malloc_and_free_hooks(
    [](const volatile void *, std::size_t) { count_allocation(); }, [](const volatile void *) {});

} // namespace

#else

// NOLINTBEGIN(bugprone-reserved-identifier,readability-identifier-naming)
extern "C" void *__libc_malloc(std::size_t);
extern "C" void *__libc_calloc(std::size_t, std::size_t);
extern "C" void *__libc_realloc(void *, std::size_t);
extern "C" void *__libc_memalign(std::size_t, std::size_t);
// NOLINTEND(bugprone-reserved-identifier,readability-identifier-naming)

#define AFTERGLOW_REPLACES extern "C" __attribute__((visibility("default")))

AFTERGLOW_REPLACES void *malloc(std::size_t size) noexcept {
    count_allocation();
    return __libc_malloc(size);
}
AFTERGLOW_REPLACES void *calloc(std::size_t count, std::size_t size) noexcept {
    count_allocation();
    return __libc_calloc(count, size);
}
AFTERGLOW_REPLACES void *realloc(void *memory, std::size_t size) noexcept {
    count_allocation();
    return __libc_realloc(memory, size);
}
AFTERGLOW_REPLACES void *memalign(std::size_t alignment, std::size_t size) noexcept {
    count_allocation();
    return __libc_memalign(alignment, size);
}
AFTERGLOW_REPLACES void *aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
    count_allocation();
    return __libc_memalign(alignment, size);
}
AFTERGLOW_REPLACES int posix_memalign(void **memory, std::size_t alignment,
                                      std::size_t size) noexcept {
    count_allocation();
    if (alignment % sizeof(void *) != 0 || (alignment & (alignment - 1)) != 0 || alignment == 0)
        return EINVAL;
    void *const allocated = __libc_memalign(alignment, size);
    if (allocated == nullptr)
        return ENOMEM;
    *memory = allocated;
    return 0;
}

#endif

TEST_CASE("a thread's allocation counter leaves out what other threads allocate") {
    constexpr int allocations_of_other = 1000;
    const std::uint64_t before = thread_allocation_count();
    std::thread([] {
        for (int i = 0; i < allocations_of_other; ++i)
            ::operator delete(::operator new(1));
    }).join();
    CHECK(thread_allocation_count() - before < allocations_of_other / 10); // starting it takes some
}

TEST_CASE("the allocation counter counts every allocation function on every thread") {
    struct alignas(64) Wide {
        char bytes[64];
    };
    const std::pair<const char *, std::function<void *()>> ways[] = {
        {"operator new", [] { return ::operator new(1); }},
        {"aligned operator new", [] { return ::operator new (64, std::align_val_t{64}); }},
        {"malloc", [] { return std::malloc(1); }},
        {"calloc", [] { return std::calloc(1, 1); }},
        {"realloc", [] { return std::realloc(nullptr, 1); }},
        {"aligned_alloc", [] { return std::aligned_alloc(64, 64); }},
        {"memalign", [] { return ::memalign(64, 64); }},
        {"posix_memalign", [] {
             void *memory = nullptr;
             return ::posix_memalign(&memory, 64, 64) == 0 ? memory : nullptr;
         }}};
    for (const auto &[name, allocate] : ways) {
        INFO(name);
        void *memory = nullptr;
        std::uint64_t before = 0, after = 0, of_thread = 0;
        std::thread([&, allocate = &allocate] {
            of_thread = thread_allocation_count();
            before = allocation_count();
            memory = (*allocate)();
            after = allocation_count();
            of_thread = thread_allocation_count() - of_thread;
        }).join();
        CHECK(memory != nullptr);
        CHECK(after == before + 1);
        CHECK(of_thread == 1);
        if (std::string(name) == "aligned operator new")
            ::operator delete (memory, std::align_val_t{64});
        else if (std::string(name) == "operator new")
            ::operator delete(memory);
        else
            std::free(memory);
    }
}
