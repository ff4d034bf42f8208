# SPDX-License-Identifier: MIT
# Completion for bash: commands, studies, options and the values that they may have, scenes that ship, policies, files.
# What there is to complete is what --help says, so it is that of the installed program.

# The first words of the rows of a command's list of --help: _poise_rows LIST COMMAND...
_poise_rows() {
  local list=$1
  shift
  "$@" --help 2>/dev/null | sed -n "/^$list:/,/^\$/p" | sed -En 's/^  ([a-z][a-z-]*) .*/\1/p'
}

_poise() {
  local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]} program=${COMP_WORDS[0]} words=()
  COMPREPLY=()
  local -a command=("$program")
  local word
  for word in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do
    [[ $word == -* ]] && break
    command+=("$word")
    # A command of `study` is a study.
    [[ ${command[1]} == study && ${#command[@]} -lt 3 ]] || break
  done
  if [[ ${#command[@]} -eq 1 || (${command[1]} == study && ${#command[@]} -eq 2) ]]; then
    [[ $current == -* ]] && mapfile -t words <<<$'--help\n--version' ||
      mapfile -t words < <(_poise_rows Subcommands "${command[@]}")
    mapfile -t COMPREPLY < <(compgen -W "${words[*]}" -- "$current")
    return
  fi
  if [[ $current == -* ]]; then
    mapfile -t words < <("${command[@]}" --help 2>/dev/null | grep -oE '^  (-[a-zA-Z],)?--[a-z-]+' | grep -oE -- '--[a-z-]+')
    mapfile -t COMPREPLY < <(compgen -W "${words[*]}" -- "$current")
    return
  fi
  if [[ $previous == --* ]]; then
    # OPTION NAME:{one,two,three}, or policies by what the help of --policy says.
    local values
    values=$("${command[@]}" --help 2>/dev/null | sed -En "s/^  (-[a-zA-Z],)?$previous [A-Z]+:\{([^}]*)\}.*/\2/p" | tr ',' ' ')
    if [[ $previous == --policy || $previous == --policies ]]; then
      values="perceptual fifo random round-robin size deepest equal-levels"
      [[ $previous == --policies ]] && values+=" oracle"
    fi
    if [[ -n $values ]]; then
      mapfile -t COMPREPLY < <(compgen -W "$values" -- "$current")
      [[ $previous != --policy || ${#COMPREPLY[@]} -gt 0 ]] && return
    fi
  fi
  case ${command[1]} in
    run | live | check | compare | tune)
      mapfile -t words < <("$program" scenes 2>/dev/null | sed -En '2,$s/^([a-z][a-z0-9-]*) .*/\1/p')
      [[ $previous == --* ]] || mapfile -t COMPREPLY < <(compgen -W "${words[*]}" -- "$current")
      ;;
  esac
  mapfile -t -O "${#COMPREPLY[@]}" COMPREPLY < <(compgen -f -- "$current")
}

complete -o filenames -F _poise poise
