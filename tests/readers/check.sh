#!/bin/sh
# Holds a results file against what is known of it: check.sh ncdump|h5dump FOLDER
set -eu
reader=$1 folder=$2
file=$folder/out.h5
values() {
  own=${1##*/}
  case $reader in
    ncdump) ncdump -p 9,17 -v "$1" "$file" | sed -n "/^ *$own =/,\$p" | sed "1s/^ *$own =//; /;/q" ;;
    h5dump) h5dump -d "/$1" -y -w 0 -m '%.17g' "$file" | sed '1,/DATA {/d' ;;
  esac | sed '/^ *ATTRIBUTE /,$d' | tr -d ' };' | tr , '\n' | grep -v '^$'
}
$reader "$file" > "$folder/$reader.txt" # all of it, texts too
grep -q 3.24 "$folder/$reader.txt"
tab=$(printf '\t')
while IFS=$tab read -r name shape wanted; do
  values "$name" > "$folder/$reader.found"
  printf '%s\n' "$wanted" | tr '\t' '\n' > "$folder/$reader.wanted"
  paste "$folder/$reader.wanted" "$folder/$reader.found" | awk -v name="$name" '
    function none(x) { return tolower(x) ~ /nan/ || x == "_" }
    { same = none($1) ? none($2) : $2 == "_" ? $1 == -1 : $1 + 0 == $2 + 0 && $2 != "" }
    !same { print name " differs at " NR - 1 ": " $1 " and " $2; bad = 1 }
    END { exit bad }'
done < "$folder/numbers.tsv"
echo "$reader read $(wc -l < "$folder/numbers.tsv") arrays"
