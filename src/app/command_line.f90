! SPDX-License-Identifier: BSD-3-Clause
!> The command line as data: which command, on which file, with which options.
module sig_command_line
  use sig_errors, only: error_t, make_error
  use sig_text, only: did_you_mean, join, read_integer, split, string_t, to_text
  implicit none(type, external)
  private
  public :: command_t, parse_command_line, usage

  type :: command_t
    !> init, check, solve, sample, train, validate, run, predict, describe, help or version
    character(:), allocatable :: name
    !> deck, the mesh of init, or the model of predict and describe
    character(:), allocatable :: file
    !> `a=1,b=2`; empty without --at
    character(:), allocatable :: at
    !> CSV of points, file of answers; empty without the options
    character(:), allocatable :: points
    character(:), allocatable :: output
    !> file that keeps what is said; empty without --log
    character(:), allocatable :: log
    logical :: is_quiet = .false.
    logical :: is_strict = .false.
    logical :: has_benchmark = .false.
    logical :: has_fields = .false.
    !> of predict; 0 = as many as there are processors
    integer :: n_threads = 0
    !> what goes to PETSc's options database: `-name value ...`
    character(:), allocatable :: petsc_options
  end type command_t

  character(*), parameter :: see_help = 'see signorom --help'
  integer, parameter :: most_threads = 1000

contains

  !> Errors: no or an unknown command or option, an option without its value or of another command, a missing file.
  subroutine parse_command_line(arguments, command, error)
    type(string_t), intent(in) :: arguments(:)
    type(command_t), intent(out) :: command
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    command = command_t(name='', file='', at='', points='', output='', log='', petsc_options='')
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
    call check_command(command, error)
  end subroutine parse_command_line

  !> A word too many; a blank between parameters of a point makes one.
  subroutine refuse_word(word, command, error)
    character(*), intent(in) :: word
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: hint

    hint = see_help
    if (command%at /= '' .and. index(word, '=') > 0) hint = 'write --at ' // command%at // ',' // word
    call make_error(error, 'unexpected argument ''' // word // '''', hint=hint)
  end subroutine refuse_word

  !> Reads one option and its value; leaves i at the last argument it used. A single hyphen marks an option of PETSc.
  subroutine take_option(arguments, i, command, error)
    type(string_t), intent(in) :: arguments(:)
    integer, intent(inout) :: i
    type(command_t), intent(inout) :: command
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: value

    select case (arguments(i)%text)
    case ('--help', '-h')
      command%name = 'help'
    case ('--version')
      command%name = 'version'
    case ('--quiet')
      command%is_quiet = .true.
    case ('--strict')
      command%is_strict = .true.
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
    case ('--output')
      call take_value(arguments, i, command%output, error)
    case ('--log')
      call take_value(arguments, i, command%log, error)
    case ('--threads')
      call take_value(arguments, i, value, error)
      if (.not. allocated(error)) call take_threads(value, command%n_threads, error)
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

  !> What belongs to what.
  subroutine check_command(command, error)
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: kind

    if (command%name == 'help' .or. command%name == 'version') return
    if (command%name == '') then
      call make_error(error, 'no command; one of ' // join(command_words(), ', ') // ' is needed', hint=see_help)
    else if (.not. is_in(command%name, command_words())) then
      call make_error(error, 'unknown command ''' // command%name // '''; the commands are ' // join(command_words(), ', '), &
        hint=suggestion(command%name, command_words()))
    else if (command%file == '') then
      kind = 'a deck (.yaml)'
      if (command%name == 'init') kind = 'a mesh (.msh)'
      if (is_on_model(command)) kind = 'a model (model.h5)'
      call make_error(error, 'the command ' // command%name // ' needs ' // kind, hint=see_help)
    else if (command%name == 'predict' .and. ((command%at == '') .eqv. (command%points == ''))) then
      call make_error(error, 'predict needs either --at or --points', hint='for example: signorom predict ' // &
        command%file // ' --at squeeze=0.2')
    else if ((is_on_model(command) .or. command%name == 'init') .and. command%petsc_options /= '') then
      call make_error(error, command%name // ' works without PETSc and takes no option of it:' // command%petsc_options)
    else if (command%has_fields .and. .not. (command%name == 'check' .or. command%name == 'predict')) then
      call make_error(error, '--fields goes with check and predict, not with ' // command%name)
    else if (command%name == 'check' .and. command%at /= '' .and. .not. command%has_fields) then
      call make_error(error, '--at goes with check only where --fields does, too')
    else if (command%at /= '' .and. .not. any(command%name == [character(7) :: 'check', 'predict', 'solve'])) then
      call make_error(error, '--at goes with predict, solve and check --fields, not with ' // command%name)
    else if (command%has_benchmark .and. .not. (command%name == 'run' .or. command%name == 'validate')) then
      call make_error(error, '--benchmark goes with run and validate, not with ' // command%name)
    else if (command%name /= 'predict' .and. (command%points /= '' .or. command%output /= '' .or. command%is_strict &
      .or. command%n_threads > 0)) then
      call make_error(error, '--points, --output, --strict and --threads go with predict, not with ' // command%name)
    end if
  end subroutine check_command

  !> Whether the command takes a model instead of a deck.
  pure logical function is_on_model(command)
    type(command_t), intent(in) :: command

    is_on_model = command%name == 'predict' .or. command%name == 'describe'
  end function is_on_model

  function command_words() result(words)
    type(string_t), allocatable :: words(:)

    words = split('init,check,solve,sample,train,validate,run,predict,describe', ',')
  end function command_words

  function option_words() result(words)
    type(string_t), allocatable :: words(:)

    words = split('--help,--version,--quiet,--strict,--benchmark,--fields,--at,--points,--output,--threads,--log', ',')
  end function option_words

  logical function is_in(word, words)
    character(*), intent(in) :: word
    type(string_t), intent(in) :: words(:)
    integer :: i

    is_in = .false.
    do i = 1, size(words)
      is_in = is_in .or. words(i)%text == word
    end do
  end function is_in

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

  !> The text that --help prints.
  function usage() result(text)
    character(:), allocatable :: text
    character(1), parameter :: nl = new_line('a')

    text = 'usage: signorom COMMAND FILE [options]' // nl // &
      '       mpirun -n N signorom COMMAND FILE [options]' // nl // nl // &
      'Command on a mesh (.msh):' // nl // &
      '  init MESH       write a first deck beside the mesh, with places to fill in' // nl // nl // &
      'Commands on a deck (.yaml):' // nl // &
      '  check DECK      read deck and mesh, print the deck with all defaults and the sizes' // nl // &
      '  solve DECK      full-order solution at the deck''s output points, or --at' // nl // &
      '  sample DECK     full-order snapshots of the training points (goes on where a killed run was)' // nl // &
      '  train DECK      reduced model of the snapshots' // nl // &
      '  validate DECK   reduced against full-order model at the test points' // nl // &
      '  run DECK        sample, train, validate, and fields at the output points' // nl // nl // &
      'Commands on a model:' // nl // &
      '  predict MODEL   answer of the reduced model at one or many points, as CSV' // nl // &
      '  describe MODEL  what the model is, where it is valid and how well it was validated' // nl // nl // &
      'Options:' // nl // &
      '  --at a=1,b=2    a parameter point (predict, solve, check --fields)' // nl // &
      '  --fields        write check.xdmf for ParaView and signorom-post check: supports, loads, contact at the' // nl // &
      '                  middle of the parameter ranges or --at (check);' // nl // &
      '                  write displacement, stress, contact of each point: fields.xdmf in a folder beside the table,' // nl // &
      '                  of a model whose deck has reduction.fields: true (predict)' // nl // &
      '  --points FILE   CSV with a column per parameter (predict)' // nl // &
      '  --output FILE   where the CSV of predict goes instead of the terminal' // nl // &
      '  --threads N     threads of predict; as many as there are processors without it' // nl // &
      '  --strict        a point outside the trained box is an error, not a warning (predict)' // nl // &
      '  --benchmark     measure the times of queries and of a solver that factors anew (validate, run)' // nl // &
      '  --quiet         say nothing but warnings and errors' // nl // &
      '  --log FILE      add all that is said to a file, with dates, --quiet or not' // nl // &
      '  --help, --version' // nl // &
      '  -fom_..., -active_set_..., -vi_..., -pod_...   options of PETSc, after the file; they beat the deck''s petsc_options' // &
      nl // nl // &
      'Exit codes: 0 done, 1 internal error, 2 error in deck, mesh, file or command line, 3 not converged,' // nl // &
      '            130 stopped by SIGINT or SIGTERM (the same command goes on).'
  end function usage
end module sig_command_line
