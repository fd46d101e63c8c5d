# What the scripts here share; to be sourced. `checks_ended` prints the last line and gives the exit status.
passed=0
failed=0

# name, exit status of what is checked (0: it holds), what was seen
check() {
  if (($2 == 0)); then
    passed=$((passed + 1))
    echo "ok      $1: $3"
  else
    failed=$((failed + 1))
    echo "FAILED  $1: $3"
  fi
}

checks_ended() {
  echo "$passed passed, $failed failed"
  ((failed == 0))
}

# A field of a flat JSON file.
value() { grep -o "\"$1\": *[^,}]*" "$2" | head -n 1 | sed 's/^[^:]*: *//'; }

# Milliseconds since some point in the past.
now() { echo $(($(date +%s%N) / 1000000)); }
