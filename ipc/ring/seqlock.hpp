// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

// Where stores can go past the caches. ThreadSanitizer takes such a store for one that is not
// atomic; it is two words, each of them at once.
#if defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define AFTERGLOW_THREAD_SANITIZER
#endif
#elif defined(__SANITIZE_THREAD__)
#define AFTERGLOW_THREAD_SANITIZER
#endif
#if defined(__SSE2__) && !defined(AFTERGLOW_THREAD_SANITIZER)
#define AFTERGLOW_STREAMING_STORES
#include <emmintrin.h>
#endif

/// Both halves of the protocol of a ring slot (afterglow/ring.h): one writer, whose threads may
/// share the stores, and any number of readers that never write. See H.-J. Boehm, "Can seqlocks get
/// along with programming language memory models?", MSPC 2012: the payload moves in relaxed atomic
/// words, two fences keep it between the two values of the sequence.
///
/// Compiler built-ins and not std::atomic, because the memory is shared with other programs and
/// readers map it const. Real-time safe.
namespace afterglow::seqlock {

#if defined(__GNUC__) && !defined(__clang__)
// ThreadSanitizer does not model fences. It need not: all that they order is atomic.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wtsan"
#endif

/// What moves at once: a load or store of it is one plain instruction on every machine.
using Word = std::uintptr_t;
static_assert(__atomic_always_lock_free(sizeof(Word), nullptr));
static_assert(__atomic_always_lock_free(sizeof(std::uint64_t), nullptr));

/// The sequence of a slot while frame `index` is written there; one more when it is complete.
constexpr std::uint64_t writing(std::uint64_t index) {
    return 2 * index + 1;
}
constexpr std::uint64_t complete(std::uint64_t index) {
    return 2 * index + 2;
}

/// Keeps the streaming stores of store() on their side of the sequence: releases do not order them.
inline void fence_streams() {
#ifdef AFTERGLOW_STREAMING_STORES
    _mm_sfence();
#endif
}

inline void begin_write(std::uint64_t &sequence, std::uint64_t index) {
    __atomic_store_n(&sequence, writing(index), __ATOMIC_RELAXED);
    __atomic_thread_fence(__ATOMIC_RELEASE);
    fence_streams();
}

inline void end_write(std::uint64_t &sequence, std::uint64_t index) {
    fence_streams();
    __atomic_store_n(&sequence, complete(index), __ATOMIC_RELEASE);
}

/// Around the stores of a thread that begin_write() has let go on, and that lets the one go on that
/// calls end_write().
inline void begin_stores() {
    __atomic_thread_fence(__ATOMIC_RELEASE);
}
inline void end_stores() {
    fence_streams();
}

inline std::uint64_t begin_read(const std::uint64_t &sequence) {
    return __atomic_load_n(&sequence, __ATOMIC_ACQUIRE);
}

/// Whether what was read since begin_read() gave `begun` is whole.
inline bool end_read(const std::uint64_t &sequence, std::uint64_t begun) {
    __atomic_thread_fence(__ATOMIC_ACQUIRE);
    return __atomic_load_n(&sequence, __ATOMIC_RELAXED) == begun;
}

/// Copies into the shared memory. `to` is aligned to 8 bytes; the last of them is written whole,
/// filled up with zeros.
inline void store(void *to, const void *from, std::size_t bytes) {
    auto *words = static_cast<Word *>(to);
    const auto *source = static_cast<const unsigned char *>(from);
#ifdef AFTERGLOW_STREAMING_STORES
    // Faster past the caches: the old frame need not be fetched to be overwritten.
    if (reinterpret_cast<std::uintptr_t>(words) % sizeof(__m128i) != 0 && bytes >= sizeof(Word)) {
        Word word;
        std::memcpy(&word, source, sizeof word);
        __atomic_store_n(words++, word, __ATOMIC_RELAXED);
        bytes -= sizeof word;
        source += sizeof word;
    }
    for (; bytes >= sizeof(__m128i); bytes -= sizeof(__m128i), source += sizeof(__m128i)) {
        const __m128i both = _mm_loadu_si128(reinterpret_cast<const __m128i *>(source));
        _mm_stream_si128(reinterpret_cast<__m128i *>(words), both);
        words += sizeof(__m128i) / sizeof(Word);
    }
#endif
    for (; bytes >= sizeof(Word); bytes -= sizeof(Word), source += sizeof(Word)) {
        Word word;
        std::memcpy(&word, source, sizeof word);
        __atomic_store_n(words++, word, __ATOMIC_RELAXED);
    }
    if (bytes > 0) {
        Word word = 0;
        std::memcpy(&word, source, bytes);
        __atomic_store_n(words, word, __ATOMIC_RELAXED);
    }
}

/// Empties a slot of `bytes`, a multiple of 8, that begins with its sequence.
inline void clear(std::uint64_t &sequence, std::size_t bytes) {
    __atomic_store_n(&sequence, 0, __ATOMIC_RELAXED);
    __atomic_thread_fence(__ATOMIC_RELEASE);
    auto *word = reinterpret_cast<Word *>(&sequence);
    for (Word *const end = word + bytes / sizeof(Word); word != end; ++word)
        __atomic_store_n(word, 0, __ATOMIC_RELAXED);
}

/// Copies out of the shared memory. `from` is aligned to 8 bytes, and readable up to a multiple of
/// 8 bytes.
inline void load(void *to, const void *from, std::size_t bytes) {
    const auto *words = static_cast<const Word *>(from);
    auto *target = static_cast<unsigned char *>(to);
    for (; bytes >= sizeof(Word); bytes -= sizeof(Word), target += sizeof(Word)) {
        const Word word = __atomic_load_n(words++, __ATOMIC_RELAXED);
        std::memcpy(target, &word, sizeof word);
    }
    if (bytes > 0) {
        const Word word = __atomic_load_n(words, __ATOMIC_RELAXED);
        std::memcpy(target, &word, bytes);
    }
}

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic pop
#endif

} // namespace afterglow::seqlock
