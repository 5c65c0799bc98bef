! SPDX-License-Identifier: BSD-3-Clause
!> Finds signorom-post, the Python tool that trains the random forest of irregular clusters.
module sig_forest_tool
  use sig_deck_config, only: clusters_config_t
  use sig_errors, only: error_t, exit_stopped, make_error
  use sig_file_system, only: file_exists, program_folder
  use sig_shell, only: run_shell
  use sig_signals, only: is_stop_requested
  use sig_text, only: string_t
  implicit none(type, external)
  private
  public :: find_forest_tool, forest_tool_name, may_need_forest, shell_text

  character(*), parameter :: forest_tool_name = 'signorom-post'
  !> environment variable with the path of the tool
  character(*), parameter :: variable = 'SIGNOROM_POST'
  !> exit code of a shell that does not find a command
  integer, parameter :: exit_not_found = 127

contains

  !> Whether the training of these clusters may need a random forest: they are irregular, and their number in the deck is not 1, or
  !> refine may split them.
  pure logical function may_need_forest(clusters)
    type(clusters_config_t), intent(in) :: clusters

    may_need_forest = clusters%method == 'irregular' .and. (clusters%number /= 1 .or. clusters%refine%is_used)
  end function may_need_forest

  !> Finds the first signorom-post that can train a forest, by running its check. If the environment variable SIGNOROM_POST is set,
  !> only its value is tried: a path, or a name that is looked for in PATH. Otherwise the places are PATH, the folder of the
  !> program, and the environments `venv` of a build folder. Local: call it on one rank.
  !>
  !> Errors: no tool is found; the tools that are found cannot train (the first one prints the reason on standard error); a stop is
  !> requested.
  subroutine find_forest_tool(tool, error)
    !> path or name of the tool, quoted as one word for the shell
    character(:), allocatable, intent(out) :: tool
    type(error_t), allocatable, intent(out) :: error
    type(string_t), allocatable :: places(:)
    character(:), allocatable :: unable
    integer :: i, exit_code

    call candidates(places)
    unable = ''
    do i = 1, size(places)
      if (index(places(i)%text, '/') > 0) then
        if (.not. file_exists(places(i)%text)) cycle
      end if
      tool = shell_text(places(i)%text)
      exit_code = run_shell('exec ' // tool // ' forest --check >/dev/null 2>&1')
      if (exit_code == 0) return
      if (is_stop_requested()) then
        call make_error(error, 'there is no forest yet', exit_code=exit_stopped)
        return
      end if
      if (exit_code /= exit_not_found .and. unable == '') unable = places(i)%text
    end do
    if (unable /= '') then
      exit_code = run_shell('exec ' // shell_text(unable) // ' forest --check')
      call make_error(error, &
        unable // ' is not able to train the random forest of irregular clusters; its message is printed above', &
        hint='try it: ' // shell_text(unable) // ' forest --check')
    else if (is_named()) then
      call make_error(error, 'the environment variable ' // variable // ' names ' // places(1)%text // ', which cannot be ' // &
        'started: it, or the Python that it needs, is missing', &
        hint='set the variable to the file of ' // forest_tool_name // ', which trains the random forest of irregular ' // &
        'clusters; without the variable, PATH and build/venv are searched')
    else
      call make_error(error, forest_tool_name // ', which trains the random forest of irregular clusters, is not found', &
        hint='tools/install_dependencies.sh puts it into build/venv. Elsewhere: pip install ''tools/signorom_post[forest]'', ' // &
        'and see that PATH has it, or set ' // variable // ' to its file')
    end if
  end subroutine find_forest_tool

  !> Lists the files to try, in this order. A name without a folder is looked for in PATH.
  subroutine candidates(places)
    type(string_t), allocatable, intent(out) :: places(:)
    character(:), allocatable :: folder
    character(4096) :: value

    if (is_named()) then
      call get_environment_variable(variable, value)
      ! by hand: gfortran 12 loses the text of a constructor inside an array constructor
      allocate (places(1))
      places(1)%text = trim(value)
      return
    end if
    folder = program_folder()
    allocate (places(4))
    places(1)%text = forest_tool_name
    places(2)%text = folder // '/' // forest_tool_name
    ! build/venv of a program in build/release, and in build
    places(3)%text = folder // '/../venv/bin/' // forest_tool_name
    places(4)%text = folder // '/venv/bin/' // forest_tool_name
  end subroutine candidates

  !> Whether the environment variable SIGNOROM_POST is set and not empty.
  logical function is_named()
    integer :: length

    call get_environment_variable(variable, length=length)
    is_named = length > 0
  end function is_named

  !> Quotes a text, so that the shell takes it as one word.
  pure function shell_text(text) result(word)
    character(*), intent(in) :: text
    character(:), allocatable :: word
    integer :: i

    word = ''''
    do i = 1, len(text)
      if (text(i:i) == '''') then
        word = word // '''\'''''
      else
        word = word // text(i:i)
      end if
    end do
    word = word // ''''
  end function shell_text
end module sig_forest_tool
