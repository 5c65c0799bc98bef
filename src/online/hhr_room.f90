! SPDX-License-Identifier: BSD-3-Clause
!> Work arrays of a hyper-reduced model for one thread, and the answer from a solution of its complementarity problem.
module sig_hhr_room
  use sig_answer, only: answer_t
  use sig_hhr_data, only: hhr_data_t
  use sig_hhr_system, only: hhr_system_t
  use sig_kinds, only: rk
  use sig_lcp, only: lcp_solution_t, lcp_workspace_t
  use sig_multiplier_fit, only: multiplier_fit_workspace_t
  use sig_reduced, only: room_t
  implicit none(type, external)
  private
  public :: hhr_room_t, swap_roles, take

  type, extends(room_t) :: hhr_room_t
    type(lcp_workspace_t) :: workspace
    type(lcp_solution_t) :: solution
    type(lcp_solution_t) :: other_solution
    type(multiplier_fit_workspace_t) :: fit
    !> system of the point that was solved last, where the stiffness depends on the parameters
    type(hhr_system_t) :: system
    !> whether K_r of that system was numerically singular
    logical :: is_singular = .false.
    !> (q, coordinates without contact forces), shape (n_rows + n_modes)
    real(rk), allocatable :: response(:)
    !> shape (n_rows)
    logical, allocatable :: start(:)
    !> [length] shape (n_modes)
    real(rk), allocatable :: coordinates(:)
    !> [force] forces of the domain, and the forces for the coordinates (hhr_system_t%forces_of), shape (n_rows)
    real(rk), allocatable :: forces(:)
    real(rk), allocatable :: held_forces(:)
    !> [force] forces of all contacts, and work arrays for energies; shape (n_multipliers)
    real(rk), allocatable :: multipliers(:)
    real(rk), allocatable :: opening(:)
  contains
    procedure :: create
  end type hhr_room_t

contains

  !> Allocates the work arrays for a cluster. Requires: a new room.
  subroutine create(self, data)
    class(hhr_room_t), intent(inout) :: self
    !> the data, after complete_cluster
    type(hhr_data_t), intent(in) :: data

    associate (n_multipliers => size(data%dual_snapshots, 1))
      allocate (self%response(data%n_rows + data%n_modes), self%start(data%n_rows), self%coordinates(data%n_modes))
      allocate (self%forces(data%n_rows), self%held_forces(data%n_rows))
      allocate (self%multipliers(n_multipliers), self%opening(n_multipliers))
    end associate
    if (data%varying%is_there()) call self%system%reserve(data)
  end subroutine create

  !> Fills an answer from a solution of the condensed problem: method, reason, number of iterations, residual, n_solutions, forces
  !> and status of the rows of the domain, and coordinates. Without a solution the coordinates stay unchanged, and no row has a
  !> force. It does not solve the problem.
  subroutine take(system, room, solution, answer)
    !> system of the point
    type(hhr_system_t), intent(in) :: system
    !> in: response of the point; out: held_forces
    type(hhr_room_t), intent(inout) :: room
    type(lcp_solution_t), intent(in) :: solution
    type(answer_t), intent(inout) :: answer
    integer :: i

    answer%n_iterations = 0
    call answer%take_solution(solution, solution%method)
    answer%multipliers_rid = solution%lambda
    answer%is_active = solution%is_active
    if (solution%reason <= 0) return
    call system%forces_of(solution%lambda, room%response, answer%multipliers_rid, room%held_forces)
    do i = 1, size(system%anchors)
      answer%is_active(system%anchors(i)) = answer%multipliers_rid(system%anchors(i)) > 0
    end do
    call system%coordinates(room%response, room%held_forces, answer%coordinates)
  end subroutine take

  !> Negates the entries of the anchors in `is_closed`, and so converts `contact is closed` to `unknown is not zero` or back,
  !> because the unknown of an anchor is its opening. It uses no temporary array.
  pure subroutine swap_roles(anchors, is_closed)
    !> rows that are anchors, 1-based
    integer, intent(in) :: anchors(:)
    logical, intent(inout) :: is_closed(:)
    integer :: i

    do i = 1, size(anchors)
      is_closed(anchors(i)) = .not. is_closed(anchors(i))
    end do
  end subroutine swap_roles
end module sig_hhr_room
