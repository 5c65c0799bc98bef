! SPDX-License-Identifier: BSD-3-Clause
!> Makes texts of the table of commands: --help, the manual page signorom(1), and the completion in bash.
module sig_command_help
  use sig_command_table, only: command_words, commands, exit_codes, file_kind_of, file_kind_t, file_kinds, is_option_of, &
    option_words, options, petsc_options
  use sig_text, only: join, split
  implicit none(type, external)
  private
  public :: usage, usage_of, manual_page, bash_completion

  character(1), parameter :: nl = new_line('a')
  integer, parameter :: text_width = 110

contains

  !> Returns the text that --help prints, without a line end at its end.
  function usage() result(text)
    character(:), allocatable :: text
    integer :: i

    text = 'usage: signorom COMMAND FILE [options]' // nl // &
      '       mpirun -n N signorom COMMAND FILE [options]' // nl
    do i = 1, size(file_kinds)
      text = text // commands_on(file_kinds(i))
    end do
    text = text // nl // 'Options:' // nl
    do i = 1, size(options)
      text = text // row(trim(options(i)%name) // ' ' // options(i)%value, summary_of_option(i), 18)
    end do
    text = text // row('', petsc_options, 2) // nl // 'Exit codes:' // nl
    do i = 1, size(exit_codes)
      text = text // row(exit_codes(i)%code, exit_codes(i)%summary, 18)
    end do
    text = text(:len(text) - 1)
  end function usage

  !> Returns the text that --help prints behind a command: what it does, and its options; without a line end at its end.
  function usage_of(command) result(text)
    !> of the table
    character(*), intent(in) :: command
    character(:), allocatable :: text
    integer :: i

    i = findloc(commands%name == command, .true., dim=1)
    text = 'usage: signorom ' // command // ' ' // trim(commands(i)%file) // ' [options]' // nl
    if (commands(i)%file == 'DECK') text = text // '       mpirun -n N signorom ' // command // ' DECK [options]' // nl
    text = text // nl // row('', commands(i)%summary, 0) // nl // 'Options:' // nl
    do i = 1, size(options)
      if (is_option_of(options(i), command)) &
        text = text // row(trim(options(i)%name) // ' ' // options(i)%value, options(i)%summary, 18)
    end do
    if (file_kinds(file_kind_of(command))%name == 'DECK') text = text // row('', petsc_options, 2)
    text = text // nl // 'signorom --help shows all commands and the exit codes.'
  end function usage_of

  !> Returns an empty line, the heading of one kind of file, and the rows of the commands that work on it, with line ends.
  function commands_on(kind) result(text)
    type(file_kind_t), intent(in) :: kind
    character(:), allocatable :: text
    integer :: i

    text = nl // trim(kind%heading) // nl
    do i = 1, size(commands)
      if (commands(i)%file == kind%name) &
        text = text // row(trim(commands(i)%name) // ' ' // kind%name, commands(i)%summary, 18)
    end do
  end function commands_on

  !> Returns what option i of the table does, 1-based, and behind it in brackets the commands that have it; no brackets if all have
  !> it.
  function summary_of_option(i) result(text)
    integer, intent(in) :: i
    character(:), allocatable :: text

    text = trim(options(i)%summary)
    if (options(i)%commands /= '') text = text // ' (' // join(split(trim(options(i)%commands), ' '), ', ') // ')'
  end function summary_of_option

  !> Returns a row of --help, with line ends: two blanks, the name, and the meaning, which fills lines of text_width characters and
  !> begins behind the first `column` characters of each. Behind a name that is too long for this it begins after one blank, and the
  !> first line may be longer. If the name is empty, `column` blanks stand in its place.
  pure function row(name, meaning, column) result(text)
    character(*), intent(in) :: name, meaning
    integer, intent(in) :: column
    character(:), allocatable :: text, rest
    integer :: n_fit

    text = '  ' // trim(name) // repeat(' ', max(1, column - 2 - len_trim(name)))
    if (name == '') text = repeat(' ', column)
    rest = trim(meaning)
    do while (len(rest) > text_width - column)
      n_fit = index(rest(:text_width - column), ' ', back=.true.)
      text = text // rest(:n_fit - 1) // nl // repeat(' ', column)
      rest = rest(n_fit + 1:)
    end do
    text = text // rest // nl
  end function row

  !> Returns the manual page in the language of man(7). Its head names the given version of the program.
  function manual_page(version) result(text)
    character(*), intent(in) :: version
    character(:), allocatable :: text
    integer :: i

    text = '.TH SIGNOROM 1 "" "signorom ' // version // '" "User Commands"' // nl // &
      '.SH NAME' // nl // 'signorom \- contact of elastic bodies for many parameter values, and its reduced models' // nl // &
      '.SH SYNOPSIS' // nl // '.B signorom' // nl // '.I COMMAND FILE' // nl // '[options]' // nl // '.br' // nl // &
      '.B mpirun \-n' // nl // '.I N' // nl // '.B signorom' // nl // '.I COMMAND FILE' // nl // '[options]' // nl // &
      '.SH DESCRIPTION' // nl // 'Signorom solves unilateral contact between elastic bodies with Lagrange multipliers. From ' // &
      'solutions at training points it makes a reduced model, which answers a new parameter point in microseconds. A deck ' // &
      '(YAML) names the mesh of gmsh, materials, supports, loads, contacts and parameters.' // nl // '.SH COMMANDS' // nl
    do i = 1, size(commands)
      text = text // '.TP' // nl // '.BI ' // trim(commands(i)%name) // ' " ' // trim(commands(i)%file) // '"' // nl // &
        escaped(trim(commands(i)%summary)) // nl
    end do
    text = text // '.SH OPTIONS' // nl
    do i = 1, size(options)
      text = text // '.TP' // nl // '.BI ' // escaped(trim(options(i)%name)) // ' " ' // trim(options(i)%value) // '"' // nl // &
        escaped(summary_of_option(i)) // nl
    end do
    text = text // '.PP' // nl // escaped(petsc_options) // nl // '.SH EXIT STATUS' // nl
    do i = 1, size(exit_codes)
      text = text // '.TP' // nl // '.B ' // trim(exit_codes(i)%code) // nl // trim(exit_codes(i)%summary) // nl
    end do
    text = text // '.SH EXAMPLES' // nl // '.EX' // nl // 'signorom check part.yaml \-\-fields' // nl // &
      'mpirun \-n 4 signorom run part.yaml' // nl // 'signorom predict results/part/model.h5 \-\-at load=3.5' // nl // '.EE' // nl
  end function manual_page

  !> Returns the words with `\-` for each hyphen, so that readers can copy them into a shell.
  function escaped(words) result(text)
    character(*), intent(in) :: words
    character(:), allocatable :: text

    text = join(split(words, '-'), '\-')
  end function escaped

  !> Returns a script for bash. It completes the command; behind it folders, files with the ending that the command takes, and the
  !> options of the command; after --points, --output and --history folders and files *.csv, after --log folders and all files, and
  !> after --at and --threads nothing.
  function bash_completion() result(text)
    character(:), allocatable :: text
    type(file_kind_t) :: kind
    integer :: i

    text = '# Completion of signorom in bash; in zsh after `autoload bashcompinit && bashcompinit`.' // nl // &
      '_signorom() {' // nl // &
      '  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} files= words=' // nl // &
      '  [ $COMP_CWORD = 1 ] && before=signorom' // nl // &
      '  case $before in' // nl // &
      '    --points|--output|--history) files="*.csv" ;;' // nl // &
      '    --log) files="*" ;;' // nl // &
      '    --at|--threads) ;;' // nl // &
      '    signorom) words="' // join(command_words(), ' ') // ' --help --version" ;;' // nl // &
      '    *) case ${COMP_WORDS[1]} in' // nl
    do i = 1, size(commands)
      kind = file_kinds(file_kind_of(commands(i)%name))
      text = text // '      ' // trim(commands(i)%name) // ') files="*' // trim(kind%ending) // '" words="' // &
        join(option_words(trim(commands(i)%name)), ' ') // '" ;;' // nl
    end do
    text = text // '    esac ;;' // nl // '  esac' // nl // &
      '  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")' // nl // &
      '  [ -n "$files" ] || return 0' // nl // &
      '  compopt -o filenames 2>/dev/null' // nl // &
      '  mapfile -t -O "${#COMPREPLY[@]}" COMPREPLY < <(compgen -d -- "$word"; compgen -f -X "!$files" -- "$word")' // nl // &
      '}' // nl // 'complete -F _signorom signorom' // nl
  end function bash_completion
end module sig_command_help
