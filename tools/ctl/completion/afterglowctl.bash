# bash completion for afterglowctl                                         -*- shell-script -*-
# SPDX-License-Identifier: Apache-2.0

_afterglowctl() {
    local commands='status monitor stats latency snapshot mode policy request hold requests measure
        reload log-level devices probe calibration characterise calibrate'
    local keys='Mode IntervalFrames TargetError MeasurementPrice CoverageFloor ShortestInterval
        LongestInterval DutyCycleBudget BudgetBurst TofPower IdlePower CorePower'
    local modes='auto always-on interval off'
    local rig='--color --tof --color-size --tof-size --fisheye --translation-unit --invert'
    local levels='emerg alert crit err warning notice info debug'
    local current=${COMP_WORDS[COMP_CWORD]}

    # What the words so far say: the command and its arguments, without options and their values.
    local command='' arguments=() i
    for ((i = 1; i < COMP_CWORD; ++i)); do
        case ${COMP_WORDS[i]} in
        --)
            # The words of another command; let it be completed as such.
            _command_offset $((i + 1)) 2>/dev/null
            return
            ;;
        --bus | --frames | --error | --max-age | --reason | --color | --tof | --color-size | --tof-size | \
            --translation-unit | --config | --recording | --seconds | -o | --output) ((++i)) ;;
        -*) ;;
        *)
            if [[ -z $command ]]; then
                command=${COMP_WORDS[i]}
            elif [[ $command == policy || $command == calibration ]]; then
                command+=" ${COMP_WORDS[i]}"
            else
                arguments+=("${COMP_WORDS[i]}")
            fi
            ;;
        esac
    done
    ((i == COMP_CWORD)) || return 0 # a value of an option: numbers and words of the person's own

    local options='' words='' count=${#arguments[@]}
    case $command in
    '') options=--version words=$commands ;;
    monitor | latency) options=--frames ;;
    stats) options=--reset ;;
    characterise) options='--config --recording --seconds --output' ;;
    snapshot | probe) ((count > 0)) || words=FILES ;;
    mode) ((count > 0)) || words=$modes ;;
    log-level) ((count > 0)) || words=$levels ;;
    calibrate) ((count > 0)) && words=FILES || words='print-board capture solve' ;;
    calibration) words='show check convert' ;;
    'calibration show' | 'calibration check') options=$rig words=FILES ;;
    'calibration convert') options="$rig --output" words=FILES ;;
    policy) words='get set save' ;;
    'policy get') ((count > 0)) || words=$keys ;;
    'policy set')
        if ((count == 0)); then
            words=$keys
        elif ((count == 1)) && [[ ${arguments[0]} == [Mm]ode ]]; then
            words=$modes
        fi
        ;;
    request)
        options='--error --max-age --reason'
        ((count > 0)) && words=FILES || words=PROGRAMS
        ;;
    hold)
        options=--reason
        if ((count == 0)); then words=$modes; elif ((count == 1)); then words=PROGRAMS; else words=FILES; fi
        ;;
    esac

    if [[ $current == -* ]]; then
        mapfile -t COMPREPLY < <(compgen -W "$options --system --session --bus --json --help" -- "$current")
        return
    fi
    case $words in
    FILES)
        compopt -o filenames 2>/dev/null
        mapfile -t COMPREPLY < <(compgen -f -- "$current")
        ;;
    PROGRAMS) mapfile -t COMPREPLY < <(compgen -c -- "$current") ;;
    *) mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current") ;;
    esac
}
complete -F _afterglowctl afterglowctl
