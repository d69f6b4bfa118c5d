#!/bin/sh
# Median step time of every cell of a results file: read.sh OUT.h5 [ncdump|h5dump]
# Cells are counted in the order of the file (the last axis varies fastest), from 0.
extent() { h5dump -H -d "$1" "$file" | sed -n 's/.*SIMPLE { ( \([0-9]*\) ).*/\1/p'; }
file=$1 reps=$(extent /rep) cycles=$(extent /cycle)
case ${2:-ncdump} in
  ncdump) ncdump -v duration "$file" | sed '1,/^ duration =/d' ;;
  h5dump) h5dump -d /duration -y -w 0 -m "%.17g" "$file" | sed '1,/DATA {/d' ;;
esac | sed '/^ *ATTRIBUTE /,$d; /^group:/,$d' | tr -d ' };' | tr , '\n' | grep -v '^$' |
  awk -v reps="$reps" -v cycles="$cycles" '{
    phase = int((NR - 1) / cycles) % 6                  # the last one is "step"
    if (phase == 5 && $1 != "_" && $1 != "NaN" && $1 != "nan")
      printf "%d %.15g\n", (NR - 1) / (cycles * 6 * reps), $1
  }' | sort -k1,1n -k2,2n |
  awk 'function flush() { if (n) printf "%d\t%.15g\n", cell, (v[int((n + 1) / 2)] + v[int(n / 2) + 1]) / 2 }
    $1 != cell { flush(); n = 0; cell = $1 } { v[++n] = $2 } END { flush() }'
