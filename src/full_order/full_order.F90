! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> The owner of a command's full-order problem: the mesh is read once, the problem is built once, and every solver is made once.
!>
!> Ranks work in groups on different points. Each way to split them is a team with a solver of its own, which waits until a stage
!> needs it and then serves all later stages.
module sig_full_order
  use sig_deck_config, only: deck_config_t
  use sig_errors, only: error_t
  use sig_petsc_support, only: rank_and_size
  use sig_point_solver, only: point_solver_t
  use sig_problem, only: problem_t
  use sig_problem_loading, only: load_problem
  use sig_rank_groups, only: create_rank_groups, number_of_groups, rank_groups_t
  use petsc
  implicit none(type, external)
  private
  public :: full_order_t, team_t

  !> All ranks in groups of nearly equal size, and the solver of this rank's group.
  type :: team_t
    type(rank_groups_t) :: groups
    type(point_solver_t) :: solver
    !> the solver was made
    logical :: is_ready = .false.
  contains
    procedure :: make_ready
    procedure, private :: destroy => destroy_team
  end type team_t

  !> A pointer to one team, so that the team stays at its place in memory while the list of teams grows.
  type :: team_pointer_t
    type(team_t), pointer :: team => null()
  end type team_pointer_t

  !> The problem of a command, and all teams that its stages asked for.
  type :: full_order_t
    !> the same on all ranks
    type(problem_t) :: problem
    !> load has built the problem
    logical :: is_loaded = .false.
    type(team_pointer_t), allocatable, private :: teams(:)
  contains
    procedure :: load
    procedure :: team_for
    procedure :: ready_team
    procedure :: whole_team
    procedure :: n_solved
    procedure :: destroy
  end type full_order_t

contains

  !> Reads the mesh and builds the problem of a deck. Does nothing if a problem is loaded, whatever the deck. Must not be called
  !> again after an error. Errors: those of load_problem, the same on all ranks. Collective on all ranks.
  subroutine load(self, deck, error, ierr)
    class(full_order_t), intent(inout) :: self
    type(deck_config_t), intent(in) :: deck
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr

    ierr = 0
    if (self%is_loaded) return
    allocate (self%teams(0))
    PetscCall(load_problem(deck, PETSC_COMM_WORLD, self%problem, error, ierr))
    self%is_loaded = .not. allocated(error)
  end subroutine load

  !> Returns the team that divides points among its groups. Makes it, without its solver, if there is none with this number of
  !> groups. The team belongs to `self`. Requires: load. Collective on all ranks.
  subroutine team_for(self, n_wanted, n_points, team, ierr)
    class(full_order_t), intent(inout) :: self
    !> wanted number of groups, 0 = one per rank; there are never more groups than ranks or points
    integer, intent(in) :: n_wanted
    !> number of points to be solved
    integer, intent(in) :: n_points
    type(team_t), pointer, intent(out) :: team
    PetscErrorCode, intent(out) :: ierr
    type(team_pointer_t) :: added
    integer :: i, n_groups, n_ranks, rank

    PetscCall(rank_and_size(PETSC_COMM_WORLD, rank, n_ranks, ierr))
    n_groups = number_of_groups(n_wanted, n_points, n_ranks)
    do i = 1, size(self%teams)
      team => self%teams(i)%team
      if (team%groups%n_groups == n_groups) return
    end do
    allocate (added%team)
    team => added%team
    PetscCall(create_rank_groups(n_groups, n_points, team%groups, ierr))
    self%teams = [self%teams, added]
  end subroutine team_for

  !> Returns the first team that has its solver. If no team has one, returns that of whole_team. Requires: load. Collective on all
  !> ranks.
  subroutine ready_team(self, team, ierr)
    class(full_order_t), intent(inout) :: self
    type(team_t), pointer, intent(out) :: team
    PetscErrorCode, intent(out) :: ierr
    integer :: i

    ierr = 0
    do i = 1, size(self%teams)
      team => self%teams(i)%team
      if (team%is_ready) return
    end do
    PetscCall(self%whole_team(team, ierr))
  end subroutine ready_team

  !> Returns the team with all ranks in one group, and makes its solver if there is none yet. Requires: load. Collective on all
  !> ranks.
  subroutine whole_team(self, team, ierr)
    class(full_order_t), intent(inout) :: self
    type(team_t), pointer, intent(out) :: team
    PetscErrorCode, intent(out) :: ierr

    PetscCall(self%team_for(1, 1, team, ierr))
    PetscCall(team%make_ready(self%problem, ierr))
  end subroutine whole_team

  !> Returns the number of points that the groups of this rank have solved; 0 before load.
  pure integer function n_solved(self)
    class(full_order_t), intent(in) :: self
    integer :: i

    n_solved = 0
    if (.not. allocated(self%teams)) return
    do i = 1, size(self%teams)
      n_solved = n_solved + self%teams(i)%team%solver%n_solved
    end do
  end function n_solved

  !> Makes the solver that the problem's plan names. Does nothing if the team has it already. Collective on all ranks.
  subroutine make_ready(self, problem, ierr)
    class(team_t), intent(inout) :: self
    type(problem_t), intent(in) :: problem
    PetscErrorCode, intent(out) :: ierr

    ierr = 0
    if (self%is_ready) return
    PetscCall(self%solver%create(problem, problem%plan, self%groups%comm, ierr))
    self%is_ready = .true.
  end subroutine make_ready

  !> Frees the solver, if there is one, and the communicator of the team. Collective on all ranks.
  subroutine destroy_team(self, ierr)
    class(team_t), intent(inout) :: self
    PetscErrorCode, intent(out) :: ierr

    ierr = 0
    if (self%is_ready) then
      PetscCall(self%solver%destroy(ierr))
    end if
    PetscCall(self%groups%destroy(ierr))
  end subroutine destroy_team

  !> Frees all teams and their solvers; pointers to teams are invalid afterwards. `problem` stays in memory, but load must be called
  !> again before a team is asked for. Does nothing before load. Collective on all ranks.
  subroutine destroy(self, ierr)
    class(full_order_t), intent(inout) :: self
    PetscErrorCode, intent(out) :: ierr
    integer :: i

    ierr = 0
    if (.not. allocated(self%teams)) return
    do i = 1, size(self%teams)
      PetscCall(self%teams(i)%team%destroy(ierr))
      deallocate (self%teams(i)%team)
    end do
    deallocate (self%teams)
    self%is_loaded = .false.
  end subroutine destroy
end module sig_full_order
