/* Wider vectors where the machine has them, chosen at run time. Every element
 * is computed in the same order, so the bits do not depend on the choice. */
#ifndef BS_CLONES_H
#define BS_CLONES_H

#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && \
    defined(__linux__) && !defined(BELTSIM_NO_CLONES)
#define BS_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define BS_CLONES
#endif

#endif
