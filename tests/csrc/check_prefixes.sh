#!/bin/sh
# usage: check_prefixes.sh NM ARCHIVE
# File foo.c may define only global names bs_foo*, except core.c and status.c,
# which hold the public interface, and phase.c's two helpers of the run's state.
"$1" -g --defined-only "$2" | awk '
  /\.o:$/ { file = $1; sub(/\.c\.o:$|\.o:$/, "", file); next }
  NF == 3 {
    name = $3
    sub(/\.(default|avx2|resolver).*$/, "", name)
    if (name ~ /^(__asan|__odr|_ZN|__x86)/) next
    wanted = "^bs_" file
    if (file == "core" || file == "status") wanted = "^bs_"
    if (file == "phase") wanted = "^bs_(phase|state)_"
    if (file == "mpi_stub") next
    if (file == "integrator") wanted = "^bs_(integrator_|sundials_version$)"
    if (name !~ wanted) { print file ".c defines " name; bad = 1 }
    count++
  }
  END { if (count < 30) { print "only " count + 0 " names seen"; bad = 1 } exit bad }'
