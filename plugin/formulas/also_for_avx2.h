#pragma once
/// Before a function with a long loop: a second version for AVX2, picked at load time, that computes the same numbers.
/// Sanitisers do not survive the picking.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_THREAD__) &&                \
    !defined(__SANITIZE_ADDRESS__)
#define EQUISTREAM_ALSO_FOR_AVX2 __attribute__((target_clones("avx2", "default")))
#else
#define EQUISTREAM_ALSO_FOR_AVX2
#endif
