! SPDX-License-Identifier: BSD-3-Clause
!> Reads the command line: which command, on which file, with which options.
module sig_command_line
  use sig_command_table, only: command_words, file_kind_of, file_kinds, is_option_of, option_words, options
  use sig_errors, only: error_t, make_error
  use sig_share, only: most_shares, read_share, share_t
  use sig_text, only: did_you_mean, join, read_integer, split, string_t, to_text
  implicit none(type, external)
  private
  public :: command_t, parse_command_line

  !> What the arguments of the program ask for.
  type :: command_t
    !> init, check, solve, sample, train, validate, run, predict, describe, help or version (also for --help, -h and --version)
    character(:), allocatable :: name
    !> help: the command whose help is wanted; empty for that of the program
    character(:), allocatable :: topic
    !> path of the deck, of the mesh (init) or of the model (predict, describe); not used for help and version
    character(:), allocatable :: file
    !> point as `a=1,b=2`; empty without --at
    character(:), allocatable :: at
    !> paths of the CSV of points and of the file of answers; empty without the options
    character(:), allocatable :: points
    character(:), allocatable :: output
    !> path of the CSV of times and tables of --history; empty without it
    character(:), allocatable :: history
    !> path of the log file; empty without --log
    character(:), allocatable :: log
    !> names of the options that were given, a blank before and after each
    character(:), allocatable :: given
    !> --help or -h stands there
    logical :: wants_help = .false.
    logical :: is_quiet = .false.
    logical :: is_strict = .false.
    logical :: has_benchmark = .false.
    logical :: has_fields = .false.
    logical :: halves_steps = .false.
    !> --share; not used without it
    type(share_t) :: share
    !> --threads of predict; 0 = as many as there are processors
    integer :: n_threads = 0
    !> what goes to PETSc's options database: `-name value ...`
    character(:), allocatable :: petsc_options
  end type command_t

  character(*), parameter :: see_help = 'see signorom --help'
  integer, parameter :: most_threads = 1000

contains

  !> Reads the arguments of the command line. The values of several --at are joined with commas; of other options the last one
  !> counts.
  !>
  !> Errors: no command, an unknown command or option, an option of another command, an option without a value or with a wrong one,
  !> no file or a word too many, predict without exactly one of --at and --points, check with --at but without --fields, PETSc
  !> options for a command without PETSc. For help and version neither the file nor combinations are checked, but a word too many is
  !> an error, and so is help about an unknown command.
  subroutine parse_command_line(arguments, command, error)
    !> without the name of the program
    type(string_t), intent(in) :: arguments(:)
    type(command_t), intent(out) :: command
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    command = command_t(name='', topic='', file='', at='', points='', output='', history='', log='', given=' ', petsc_options='')
    i = 1
    do while (i <= size(arguments))
      associate (word => arguments(i)%text)
        if (len(word) > 1 .and. word(1:1) == '-') then
          call take_option(arguments, i, command, error)
        else if (command%name == '') then
          command%name = word
        else if (command%file == '') then
          command%file = word
        else
          call refuse_word(word, command, error)
        end if
      end associate
      if (allocated(error)) return
      i = i + 1
    end do
    if (command%wants_help .or. command%name == 'help') call ask_for_help(command)
    call check_command(command, error)
  end subroutine parse_command_line

  !> Makes the command help. Its topic is the command that was given behind the word help, or before or behind --help.
  subroutine ask_for_help(command)
    type(command_t), intent(inout) :: command

    command%topic = command%name
    if (command%name == 'help') command%topic = command%file
    if (command%topic == 'help' .or. command%topic == 'version') command%topic = ''
    command%name = 'help'
  end subroutine ask_for_help

  !> Makes the error of a word too many. If --at was given before and the word contains `=`, a blank probably stands between the
  !> parameters (`--at a=1 b=2`): the hint then joins the value of --at and the word by a comma.
  subroutine refuse_word(word, command, error)
    character(*), intent(in) :: word
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: hint

    hint = see_help
    if (command%at /= '' .and. index(word, '=') > 0) then
      hint = 'write --at ' // command%at // ',' // word
      if (command%at(len(command%at):) == ',') hint = 'write --at ' // command%at // word
    end if
    call make_error(error, 'unexpected argument ''' // word // '''', hint=hint)
  end subroutine refuse_word

  !> Reads the option arguments(i) and its value into command; leaves i at the last argument it used. A single hyphen marks an
  !> option of PETSc (except -h): after the file of the command, the next argument is its value, unless this begins with a hyphen
  !> and is no number. Errors: an unknown option, an option without its value or with a wrong one; options of PETSc are not checked
  !> here.
  subroutine take_option(arguments, i, command, error)
    type(string_t), intent(in) :: arguments(:)
    integer, intent(inout) :: i
    type(command_t), intent(inout) :: command
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: value

    command%given = command%given // arguments(i)%text // ' '
    select case (arguments(i)%text)
    case ('--help', '-h')
      command%wants_help = .true.
    case ('--version')
      command%name = 'version'
    case ('--quiet')
      command%is_quiet = .true.
    case ('--strict')
      command%is_strict = .true.
    case ('--halve-steps')
      command%halves_steps = .true.
    case ('--benchmark')
      command%has_benchmark = .true.
    case ('--fields')
      command%has_fields = .true.
    case ('--at')
      call take_value(arguments, i, value, error)
      if (allocated(error)) return
      if (command%at /= '') command%at = command%at // ','
      command%at = command%at // value
    case ('--points')
      call take_value(arguments, i, command%points, error)
    case ('--history')
      call take_value(arguments, i, command%history, error)
    case ('--output')
      call take_value(arguments, i, command%output, error)
    case ('--log')
      call take_value(arguments, i, command%log, error)
    case ('--share')
      call take_value(arguments, i, value, error)
      if (allocated(error)) return
      call take_share(value, command%share, error)
    case ('--threads')
      call take_value(arguments, i, value, error)
      if (allocated(error)) return
      call take_threads(value, command%n_threads, error)
    case default
      call take_petsc_option(arguments, i, command, error)
    end select
  end subroutine take_option

  subroutine take_threads(value, n_threads, error)
    character(*), intent(in) :: value
    integer, intent(out) :: n_threads
    type(error_t), allocatable, intent(out) :: error
    logical :: is_valid

    call read_integer(value, n_threads, is_valid)
    if (.not. is_valid .or. n_threads < 1 .or. n_threads > most_threads) &
      call make_error(error, '--threads is ''' // value // '''; it must be a whole number from 1 to ' // to_text(most_threads))
  end subroutine take_threads

  subroutine take_share(value, share, error)
    character(*), intent(in) :: value
    type(share_t), intent(out) :: share
    type(error_t), allocatable, intent(out) :: error
    logical :: is_valid

    call read_share(value, share, is_valid)
    if (.not. is_valid) call make_error(error, '--share is ''' // value // '''; it must be K/N, whole numbers with ' // &
      '1 <= K <= N <= ' // to_text(most_shares), hint='for example, the second of four jobs has --share 2/4')
  end subroutine take_share

  subroutine take_petsc_option(arguments, i, command, error)
    type(string_t), intent(in) :: arguments(:)
    integer, intent(inout) :: i
    type(command_t), intent(inout) :: command
    type(error_t), allocatable, intent(out) :: error

    associate (word => arguments(i)%text)
      if (word(1:2) == '--') then
        call make_error(error, 'unknown option ''' // word // '''', hint=suggestion(word, option_words()))
        return
      end if
      command%petsc_options = command%petsc_options // ' ' // word
    end associate
    if (i == size(arguments)) return
    if (index(arguments(i + 1)%text, '-') == 1 .and. verify(arguments(i + 1)%text, '-0123456789.eE+') > 0) return
    if (command%file == '') return
    i = i + 1
    command%petsc_options = command%petsc_options // ' ' // arguments(i)%text
  end subroutine take_petsc_option

  subroutine take_value(arguments, i, value, error)
    type(string_t), intent(in) :: arguments(:)
    integer, intent(inout) :: i
    character(:), allocatable, intent(out) :: value
    type(error_t), allocatable, intent(out) :: error

    value = ''
    if (i == size(arguments)) then
      call make_error(error, 'the option ' // arguments(i)%text // ' needs a value', hint=see_help)
      return
    end if
    i = i + 1
    value = arguments(i)%text
  end subroutine take_value

  !> Checks that the command is known and has its file, and checks its options. Of help only the topic is checked; version always
  !> passes. Errors: no command, an unknown one, no file; those of check_options.
  subroutine check_command(command, error)
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error

    if (command%name == 'version' .or. (command%name == 'help' .and. command%topic == '')) return
    if (command%name == 'help') then
      if (file_kind_of(command%topic) == 0) call refuse_command(command%topic, error)
    else if (command%name == '') then
      call make_error(error, 'no command; one of ' // join(command_words(), ', ') // ' is needed', hint=see_help)
    else if (file_kind_of(command%name) == 0) then
      call refuse_command(command%name, error)
    else if (command%file == '') then
      call make_error(error, 'the command ' // command%name // ' needs ' // trim(file_kinds(file_kind_of(command%name))%text), &
        hint=see_help)
    else
      call check_options(command, error)
    end if
  end subroutine check_command

  !> Makes the error of an unknown command.
  subroutine refuse_command(name, error)
    character(*), intent(in) :: name
    type(error_t), allocatable, intent(out) :: error

    call make_error(error, 'unknown command ''' // name // '''; the commands are ' // join(command_words(), ', '), &
      hint=suggestion(name, command_words()))
  end subroutine refuse_command

  !> Checks the options of a command. Errors: an option that the command does not have; predict without exactly one of --at and
  !> --points; options of PETSc for a command without it; check with --at but without --fields.
  subroutine check_options(command, error)
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    do i = 1, size(options)
      if (index(command%given, ' ' // trim(options(i)%name) // ' ') == 0 .or. is_option_of(options(i), command%name)) cycle
      call make_error(error, trim(options(i)%name) // ' goes with ' // enumerated(split(trim(options(i)%commands), ' ')) // &
        ', not with ' // command%name)
      return
    end do
    if (command%name == 'predict' .and. ((command%at == '') .eqv. (command%points == ''))) then
      call make_error(error, 'predict needs one of --at and --points, and not both', hint='give a value to each parameter ' // &
        '(--at a=1,b=2) or name a file of points (--points points.csv); signorom describe ' // command%file // &
        ' names the parameters')
    else if (file_kinds(file_kind_of(command%name))%name /= 'DECK' .and. command%petsc_options /= '') then
      call make_error(error, command%name // ' works without PETSc and takes none of its options:' // command%petsc_options)
    else if (command%name == 'check' .and. command%at /= '' .and. .not. command%has_fields) then
      call make_error(error, 'check takes --at only together with --fields')
    end if
  end subroutine check_options

  !> Returns the words, one or more, with commas between them and ` and ` instead before the last one: `a, b and c`.
  function enumerated(words) result(text)
    type(string_t), intent(in) :: words(:)
    character(:), allocatable :: text

    text = words(size(words))%text
    if (size(words) > 1) text = join(words(:size(words) - 1), ', ') // ' and ' // text
  end function enumerated

  function suggestion(word, words) result(hint)
    character(*), intent(in) :: word
    type(string_t), intent(in) :: words(:)
    character(:), allocatable :: hint

    hint = did_you_mean(word, words)
    if (hint == '') then
      hint = see_help
    else
      hint = 'did you mean ''' // hint // '''?'
    end if
  end function suggestion
end module sig_command_line
