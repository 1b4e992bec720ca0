# Completion of `heartbus` for bash and zsh: source this file in ~/.bashrc or ~/.zshrc.
[ -n "${ZSH_VERSION-}" ] && autoload -Uz bashcompinit && bashcompinit

_heartbus() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]}
  local commands="run check mesh study report pictures trace cost example"
  local words=""
  if [ "$COMP_CWORD" = 1 ]; then
    words=$commands
  elif [ "$before" = study ]; then
    words="run plot pareto advise stability budget"
  elif [ "$before" = example ]; then
    words=$("${COMP_WORDS[0]}" example 2> /dev/null | cut -d' ' -f1)
  else
    case $word in
      -*) words=$("${COMP_WORDS[0]}" "${COMP_WORDS[1]}" --help 2> /dev/null | grep -oE -- '--[a-z-]+' | sort -u) ;;
    esac
  fi
  if [ -n "$words" ]; then
    COMPREPLY=($(compgen -W "$words" -- "$word"))
  else
    COMPREPLY=($(compgen -f -- "$word"))
  fi
}
complete -F _heartbus heartbus tools/heartbus
