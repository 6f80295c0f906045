# Completion of the words of `equistream` in bash. The branches come from --help (programs/manual/make_manual.py).

_equistream_subcommands() {
    case $1 in
@SUBCOMMANDS@
    esac
}

# With "=" behind those that take a value.
_equistream_options() {
    case $1 in
@OPTIONS@
    esac
}

_equistream_values() {
    case "$1 $2" in
@VALUES@
    esac
}

_equistream() {
    local current=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} commands="@COMMANDS@"
    local command=${COMP_WORDS[1]} subcommands options values i
    COMPREPLY=()
    if [ "$COMP_CWORD" -eq 1 ]; then
        mapfile -t COMPREPLY < <(compgen -W "$commands help --help --version" -- "$current")
        return
    fi
    if [ "$command" = help ]; then
        [ "$COMP_CWORD" -ne 2 ] || mapfile -t COMPREPLY < <(compgen -W "$commands" -- "$current")
        return
    fi
    # bash parts --option=value into three words.
    if [ "$current" = "=" ]; then
        current=
    elif [ "$before" = "=" ]; then
        before=${COMP_WORDS[COMP_CWORD - 2]}
    fi
    subcommands=$(_equistream_subcommands "$command")
    for ((i = 2; i < COMP_CWORD; ++i)); do
        case " $subcommands " in *" ${COMP_WORDS[i]} "*)
            command="$command ${COMP_WORDS[i]}"
            subcommands=
            break ;;
        esac
        # Options of another host.
        if [ "${COMP_WORDS[i]}" = --host ]; then
            local chosen=${COMP_WORDS[i + 1]}
            [ "$chosen" != "=" ] || chosen=${COMP_WORDS[i + 2]}
            [ -z "$(_equistream_options "$command --host $chosen")" ] || command="$command --host $chosen"
            break
        fi
    done
    values=$(_equistream_values "$command" "$before")
    options=$(_equistream_options "$command")
    case " $options " in
    *" $before= "*) ;; # it takes a value: one of a fixed set, or what `complete -o default` finds, a file
    *)
        values=$subcommands
        case $current in -*) values="$subcommands ${options//=/}" ;; esac # another word is a file, where none is offered
        ;;
    esac
    mapfile -t COMPREPLY < <(compgen -W "$values" -- "$current")
}

complete -o default -F _equistream equistream
