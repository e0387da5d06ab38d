/* Loops compiled twice, for AVX2 and for every machine, where the linker can
 * choose between them at start-up. Same bits: nothing is fused or reordered. */
#ifndef BM_CLONES_H
#define BM_CLONES_H

#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && \
    defined(__linux__) && !defined(BELTSIM_NO_CLONES)
#define BM_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define BM_CLONES
#endif

#endif
