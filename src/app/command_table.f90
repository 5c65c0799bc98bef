! SPDX-License-Identifier: BSD-3-Clause
!> The table of commands and options. The parser, --help, the manual page and the completion in shells read it.
module sig_command_table
  use sig_text, only: string_t
  implicit none(type, external)
  private
  public :: file_kind_t, command_entry_t, option_entry_t, exit_code_entry_t
  public :: file_kinds, commands, options, exit_codes, petsc_options, file_kind_of, is_option_of, option_words, command_words

  !> A kind of file that commands work on.
  type :: file_kind_t
    character(5) :: name
    !> name in messages
    character(18) :: text
    !> heading above its commands
    character(31) :: heading
    !> ending of the names of such files
    character(5) :: ending
  end type file_kind_t

  !> A command: what it works on and what it does.
  type :: command_entry_t
    character(8) :: name
    !> name of the kind of file that it works on
    character(5) :: file
    character(120) :: summary
  end type command_entry_t

  !> An option: its value, the commands that have it, and what it does.
  type :: option_entry_t
    character(13) :: name
    !> how its value is shown; blank where it has none
    character(7) :: value
    !> commands that have it, blanks between them; blank for all
    character(24) :: commands
    character(320) :: summary
  end type option_entry_t

  !> An exit code of the program and its meaning.
  type :: exit_code_entry_t
    character(3) :: code
    character(80) :: summary
  end type exit_code_entry_t

  type(file_kind_t), parameter :: file_kinds(*) = [ &
    file_kind_t('MESH', 'a mesh (.msh)', 'Command on a mesh (.msh):', '.msh'), &
    file_kind_t('DECK', 'a deck (.yaml)', 'Commands on a deck (.yaml):', '.yaml'), &
    file_kind_t('MODEL', 'a model (model.h5)', 'Commands on a model (model.h5):', '.h5')]

  type(command_entry_t), parameter :: commands(*) = [ &
    command_entry_t('init', 'MESH', 'write a first deck beside the mesh, with places to fill in'), &
    command_entry_t('check', 'DECK', 'read deck and mesh, print the deck with all defaults and the sizes'), &
    command_entry_t('solve', 'DECK', 'full-order solution at the deck''s output points, or --at'), &
    command_entry_t('sample', 'DECK', 'full-order snapshots of the training points (goes on where a killed run was)'), &
    command_entry_t('train', 'DECK', 'make the reduced model from the snapshots'), &
    command_entry_t('validate', 'DECK', 'compare the reduced with the full-order model at the test points'), &
    command_entry_t('run', 'DECK', 'sample, train, validate (if the deck has a test section), fields at the output points'), &
    command_entry_t('predict', 'MODEL', 'answer of the reduced model at one or many points, as CSV'), &
    command_entry_t('describe', 'MODEL', 'what the model is, where it is valid and how well it was validated')]

  type(option_entry_t), parameter :: options(*) = [ &
    option_entry_t('--at', 'a=1,b=2', 'check solve predict', 'one parameter point, with a value for ' // &
    'each parameter; check takes it only with --fields'), &
    option_entry_t('--fields', '', 'check predict', 'write fields for ParaView. check: supports, loads and contact ' // &
    'at the middle of the parameter ranges or --at (check.xdmf). predict: displacement, stress and contact of each point ' // &
    '(fields.xdmf in a folder beside the table, or beside the model without --output), where the deck of the model has ' // &
    'reduction.fields: true'), &
    option_entry_t('--points', 'FILE', 'predict', 'CSV with the points: a line with the names of all parameters, ' // &
    'then a line per point'), &
    option_entry_t('--history', 'FILE', 'predict', 'CSV with other times and tables than those of the deck: a line with time ' // &
    'and the names of all tables, then a line per time'), &
    option_entry_t('--output', 'FILE', 'predict', 'file that gets the CSV with the answers, instead of the terminal'), &
    option_entry_t('--threads', 'N', 'predict', 'number of threads for --points; default: one per processor'), &
    option_entry_t('--strict', '', 'predict', 'a point outside the trained box is an error, which ends the ' // &
    'command, and not a warning'), &
    option_entry_t('--share', 'K/N', 'sample', 'solve only share K of N of the training points, for one of N jobs that write ' // &
    'into the same results folder; sample without --share then merges the shares'), &
    option_entry_t('--halve-steps', '', 'solve', 'where materials yield or creep, also solve with halved steps, and say how ' // &
    'large the error of the time steps is'), &
    option_entry_t('--benchmark', '', 'validate run', 'also measure the times of queries, and of a ' // &
    'full-order solver that factors anew for each point'), &
    option_entry_t('--quiet', '', '', 'print only warnings, errors, and the CSV of predict'), &
    option_entry_t('--log', 'FILE', '', 'append all messages, with dates, to a file, also with --quiet'), &
    option_entry_t('--help', '', '', 'print this text; with a command, as in signorom predict --help, only what ' // &
    'concerns this command'), &
    option_entry_t('--version', '', '', 'print the version')]

  character(*), parameter :: petsc_options = 'Options with one hyphen, such as -fom_... and -pod_..., stand after the file ' // &
    'and go to PETSc. They override petsc_options of the deck.'

  type(exit_code_entry_t), parameter :: exit_codes(*) = [ &
    exit_code_entry_t('0', 'done'), &
    exit_code_entry_t('1', 'internal error'), &
    exit_code_entry_t('2', 'error in deck, mesh, file or command line'), &
    exit_code_entry_t('3', 'not converged, or a point without an answer'), &
    exit_code_entry_t('130', 'stopped by SIGINT or SIGTERM; sample and run keep the points that are finished')]

contains

  !> Returns the position in file_kinds of the kind of file that the command works on; 0 for any other
  !> word, also for help and version.
  pure integer function file_kind_of(command) result(i_kind)
    character(*), intent(in) :: command
    integer :: i

    i_kind = 0
    do i = 1, size(commands)
      if (commands(i)%name == command) i_kind = findloc(file_kinds%name, commands(i)%file, dim=1)
    end do
  end function file_kind_of

  !> Whether the option may be given with the command.
  pure logical function is_option_of(option, command)
    type(option_entry_t), intent(in) :: option
    character(*), intent(in) :: command

    is_option_of = option%commands == '' .or. index(' ' // option%commands // ' ', ' ' // trim(command) // ' ') > 0
  end function is_option_of

  !> Returns the names of the commands in the order of the table, without help and version.
  function command_words() result(words)
    type(string_t), allocatable :: words(:)
    integer :: i

    allocate (words(size(commands)))
    do i = 1, size(commands)
      words(i)%text = trim(commands(i)%name)
    end do
  end function command_words

  !> Returns the names of all options, such as `--at`; with `command`, of those that may be given with it. The short form -h and the
  !> options of PETSc are not among them.
  function option_words(command) result(words)
    character(*), intent(in), optional :: command
    type(string_t), allocatable :: words(:)
    integer :: i, n

    allocate (words(size(options)))
    n = 0
    do i = 1, size(options)
      if (present(command)) then
        if (.not. is_option_of(options(i), command)) cycle
      end if
      n = n + 1
      words(n)%text = trim(options(i)%name)
    end do
    words = words(:n)
  end function option_words
end module sig_command_table
