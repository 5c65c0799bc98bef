! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Trains the random forest that chooses the cluster of a point: runs the Python tool signorom-post and reads its result.
module sig_forest_training
  use mpi, only: MPI_Comm_rank
  use sig_deck_config, only: deck_config_t
  use sig_error_broadcast, only: broadcast_error
  use sig_errors, only: error_t, exit_stopped, make_error
  use sig_file_system, only: write_text_file
  use sig_forest, only: forest_t, read_forest
  use sig_forest_tool, only: find_forest_tool, forest_tool_name, may_need_forest, shell_text
  use sig_kinds, only: rk
  use sig_log, only: is_log_shown, log_warning
  use sig_problem, only: parameter_names
  use sig_shell, only: run_shell
  use sig_signals, only: is_stop_requested
  use sig_text, only: join, string_t, to_text
  use petsc
  implicit none(type, external)
  private
  public :: need_forest_tool, train_forest, warn_of_missing_tool

contains

  !> Checks before a long training that signorom-post can train a forest. Does nothing where the deck needs no forest. Collective
  !> on all ranks.
  !>
  !> Errors: as find_forest_tool.
  subroutine need_forest_tool(deck, error, ierr)
    type(deck_config_t), intent(in) :: deck
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    character(:), allocatable :: tool
    integer :: rank

    ierr = 0
    if (.not. may_need_forest(deck%clusters)) return
    call MPI_Comm_rank(PETSC_COMM_WORLD, rank, ierr)
    if (rank == 0) call find_forest_tool(tool, error)
    PetscCall(broadcast_error(error, PETSC_COMM_WORLD, ierr))
  end subroutine need_forest_tool

  !> Writes a warning to the log where need_forest_tool has an error other than a stop, for commands before the training. Collective
  !> on all ranks.
  subroutine warn_of_missing_tool(deck, ierr)
    type(deck_config_t), intent(in) :: deck
    PetscErrorCode, intent(out) :: ierr
    type(error_t), allocatable :: error

    PetscCall(need_forest_tool(deck, error, ierr))
    if (.not. allocated(error)) return
    if (error%exit_code == exit_stopped) return
    if (len(error%hint) > 0) error%message = error%message // '. Hint: ' // error%hint
    call log_warning('train cannot work here yet: ' // error%message)
  end subroutine warn_of_missing_tool

  !> Writes labels.csv into the results folder, runs signorom-post on it, and reads the forest.h5 that it writes. Collective on
  !> comm.
  !>
  !> Errors: labels.csv cannot be written; the tool is not found or fails (it prints the reason); a stop is requested meanwhile;
  !> forest.h5 cannot be read or does not belong to these parameters.
  subroutine train_forest(deck, points, labels, comm, forest, error, ierr)
    type(deck_config_t), intent(in) :: deck
    !> values of the parameters, shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> cluster of each point, 1-based
    integer, intent(in) :: labels(:)
    MPI_Comm, intent(in) :: comm
    type(forest_t), intent(out) :: forest
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    character(:), allocatable :: forest_path, labels_path
    integer :: rank

    labels_path = deck%output%path // '/labels.csv'
    forest_path = deck%output%path // '/forest.h5'
    call MPI_Comm_rank(comm, rank, ierr)
    work: if (rank == 0) then
      call write_text_file(labels_path, label_table(parameter_names(deck), points, labels), error)
      if (allocated(error)) exit work
      call run_tool(labels_path, forest_path, deck%clusters%seed, error)
    end if work
    PetscCall(broadcast_error(error, comm, ierr))
    if (allocated(error)) return
    call read_forest(forest_path, parameter_names(deck), forest, error)
    PetscCall(broadcast_error(error, comm, ierr))
  end subroutine train_forest

  !> Returns the text of labels.csv: a head line (the names, then `cluster`), then one line per point with its parameters and its
  !> cluster.
  pure function label_table(names, points, labels) result(text)
    type(string_t), intent(in) :: names(:)
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> cluster of each point, 1-based
    integer, intent(in) :: labels(:)
    character(:), allocatable :: text
    integer :: i, k

    text = join(names, ',') // ',cluster' // new_line('a')
    do i = 1, size(labels)
      do k = 1, size(points, 1)
        text = text // to_text(points(k, i)) // ','
      end do
      text = text // to_text(labels(i)) // new_line('a')
    end do
  end function label_table

  !> Runs signorom-post on labels_path; it writes forest_path. Local. Errors: no tool is found, or it fails; a stop is requested.
  subroutine run_tool(labels_path, forest_path, seed, error)
    character(*), intent(in) :: labels_path
    character(*), intent(in) :: forest_path
    !> of the random numbers of the forest
    integer, intent(in) :: seed
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: command, tool
    integer :: exit_code

    call find_forest_tool(tool, error)
    if (allocated(error)) return
    command = tool // ' forest ' // shell_text(labels_path) // ' --output ' // shell_text(forest_path) // &
      ' --seed ' // to_text(seed)
    if (.not. is_log_shown()) command = command // ' >/dev/null'
    exit_code = run_shell('exec ' // command)
    if (exit_code == 0) return
    if (is_stop_requested()) then
      call make_error(error, 'there is no forest yet', exit_code=exit_stopped)
    else
      call make_error(error, forest_tool_name // &
        ' could not train the random forest of irregular clusters; its message is printed above')
    end if
  end subroutine run_tool
end module sig_forest_training
