! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Contact condensed to the multipliers: W is made once, then a parameter point is a dense complementarity problem.
!>
!> With G = responses to the terms without contact, H = K^-1 B' and W = B H:
!> 0 <= lambda, W lambda + (D - B G) theta >= 0, complementary; u = G theta - H lambda.
!>
!> Where the stiffness of some bodies changes again and again (renew), W is a sum over the others, made once, and over them: bodies
!> are coupled by contact alone.
!>
!> H has a column of n_dofs numbers for each row of B, a solve with the factor of K. Where it would take too much memory, W is made
!> by elimination (sig_elimination), and H lambda is one more solve. With multigrid K is not factored at all.
!>
!> Anchors T hold bodies that only contact holds: as many pairs as there are free motions Z. G and H are then responses with closed
!> anchors, whose forces balance the other forces (Z' (F - B' lambda) = 0). The unknowns of the anchors are their openings w_T in
!> place of lambda_T; they move the bodies by -Z_T w_T with B_T Z_T = 1. With N = B Z_T the problem keeps its form: W has the blocks
!> [C, N; -N', 0], and the complementary values of w_T are the forces of the anchors, Z_T' F - N' lambda. Openings of anchors and
!> their forces are scaled by a compliance, so that all unknowns are forces.
module sig_condensed
  use sig_clock, only: wall_time
  use sig_contact_responses, only: anchor_forces, close_rows, columns_at_once, measure_work, solve_columns, solve_forces
  use sig_contact_solver, only: contact_solver_t
  use sig_contact_state, only: contact_state_t
  use sig_contact_system, only: contact_system_t
  use sig_divided_solver, only: both_parts, changing_part, divided_solver_t, staying_part
  use sig_elimination, only: eliminate_displacements
  use sig_elimination_plan, only: elimination_plan_t
  use sig_free_response, only: factor_without_contact, solve_free_response, solve_lifting
  use sig_friction_histories, only: solve_history
  use sig_friction_steps, only: friction_steps_t
  use sig_holding, only: anchors_t, find_anchors
  use sig_kinds, only: rk
  use sig_lcp, only: lcp_solution_t, lcp_workspace_t, solve_lcp
  use sig_lcp_rounding, only: drop_rounding, lcp_sizes_t
  use sig_linear_algebra, only: add_product, transposed_product
  use sig_log, only: log_warning
  use sig_memory, only: machine_memory
  use sig_petsc_support, only: broadcast_columns, max_over_ranks, multiply_block, precondition_failed, rank_and_size, sum_over_ranks
  use sig_progress, only: progress_t
  use sig_reasons, only: reason_converged, reason_linear_solver, reason_no_complementary_solution, reason_pulled_off, reason_ray
  use sig_rounding, only: rounding
  use sig_state_broadcast, only: broadcast_state
  use petsc
  implicit none(type, external)
  private
  public :: condensed_t

  !> The contact solver `condensed`. Call create, then solve or solve_points for any number of points, then destroy.
  type, extends(contact_solver_t) :: condensed_t
    !> reason_converged, or why there are no components; 0 before `create`
    integer :: reason = 0
    !> [length] G, rows of this rank, shape (n_local_dofs, n_driving_terms); with anchors (n_local_dofs, n_terms)
    real(rk), allocatable :: free_response(:, :)
    !> [length] displacements under the prescribed displacements alone, one per term, then under each lifted force; rows of this
    !> rank, shape (n_local_dofs, n_lifted_terms)
    real(rk), allocatable :: lifting(:, :)
    !> [length/force] W, with anchors the matrix at the head of this file; replicated, shape (n_rows, n_rows)
    real(rk), allocatable :: compliance(:, :)
    !> [length] D - B G, in rows of anchors their scaled forces; replicated, shape (n_rows, n_terms)
    real(rk), allocatable :: free_opening(:, :)
    !> [force*length] G'K G, shape (n_driving_terms, n_driving_terms), and [length] H'K G, shape (n_rows, n_driving_terms), with
    !> zeros in the rows of anchors; replicated. Rigid motions have no part in them.
    real(rk), allocatable :: free_energy(:, :)
    real(rk), allocatable :: shared_energy(:, :)
    type(anchors_t) :: anchors
    !> [length/force] the scale of the anchors
    real(rk) :: scale = 1
    !> [-] H is kept if it takes at most this share of the memory of the machine on all ranks together; not with multigrid, where a
    !> solve for each of its columns takes too long
    real(rk) :: memory_share = 1.0_rk / 16
    !> whether steps with friction are solved from other starts, too, to count their solutions: that takes up to three times as
    !> long
    logical :: counts_solutions = .false.
    !> what the steps before have left (save of friction_memory_t), from which histories go on; not allocated: they begin
    real(rk), allocatable :: remembered(:)
    !> the same after the last history that was solved; not allocated where no contact has friction or is tied
    real(rk), allocatable :: latest(:)
    !> of W, where H is not kept
    type(elimination_plan_t) :: elimination
    !> [length/force] rows of H of the dofs of `elimination`, shape (size(dofs), n_rows); replicated. Not allocated where W
    !> was not eliminated
    real(rk), allocatable :: dof_response(:, :)
    !> [length/force] H where it is kept, rows of this rank, shape (n_local_dofs, n_rows); the column of an anchor is minus the
    !> displacement for its scaled opening
    real(rk), allocatable, private :: contact_response(:, :)
    !> [length/force] W of the bodies whose stiffness stays, before the anchors are closed; not allocated without changing_dofs
    real(rk), allocatable, private :: staying_compliance(:, :)
    !> solves with K
    type(divided_solver_t), private :: linear_solver
    !> of contacts with friction or ties
    type(friction_steps_t), private :: steps
  contains
    procedure :: create
    procedure :: renew
    procedure :: respond
    procedure :: respond_to_rows
    procedure :: n_columns_at_once
    procedure :: hang_bodies
    procedure :: solve
    procedure :: n_points_at_once
    procedure :: solve_points
    procedure :: destroy
  end type condensed_t

  !> [flop] about half a second
  real(rk), parameter :: work_at_once = 1.0e10_rk
  integer, parameter :: fewest_points_at_once = 4, most_points_at_once = 64
  !> [s] progress is told only if the responses to contact forces take longer
  real(rk), parameter :: seconds_of_silence = 3

contains

  !> Computes the components: the lifting, and G, W and D - B G of the condensed problem. This takes one factorization, or the
  !> levels of multigrid, n_driving_terms solves, n_rows more or an elimination for W, and at most n_lifted_terms for the lifting.
  !> What solves stays until destroy. If the contacts cannot hold a body, or K cannot be factored or solved with, `reason` says why,
  !> and there are no components. With changing_dofs there are neither lifting nor energies, H is not kept, and K is factored.
  !> Collective.
  subroutine create(self, system, ierr)
    class(condensed_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    PetscErrorCode, intent(out) :: ierr

    PetscCall(self%destroy(ierr))
    call self%elimination%complete()
    self%linear_solver%is_multigrid = self%is_multigrid .and. .not. allocated(self%changing_dofs)
    if (allocated(self%changing_dofs)) &
      call self%linear_solver%divide(system%comm, self%changing_dofs(system%map%local_dofs))
    PetscCall(factor_without_contact(system, self%linear_solver, ierr))
    self%reason = self%linear_solver%reason
    if (self%reason /= reason_converged) return
    call find_anchors(system%motions, self%anchors)
    if (allocated(self%changing_dofs)) then
      PetscCall(solve_compliance(self, system, staying_part, self%staying_compliance, ierr))
    end if
    PetscCall(condense(self, system, ierr))
  end subroutine create

  !> Computes G, W and D - B G again after new values in the stiffness of the bodies with changing_dofs, whose pattern stays, and in
  !> loads, prescribed displacements and gaps. Collective.
  subroutine renew(self, system, ierr)
    class(condensed_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    PetscErrorCode, intent(out) :: ierr

    if (self%reason /= reason_converged .or. .not. allocated(self%staying_compliance)) then
      PetscCall(self%create(system, ierr))
      return
    end if
    PetscCall(factor_without_contact(system, self%linear_solver, ierr))
    self%reason = self%linear_solver%reason
    if (self%reason /= reason_converged) return
    PetscCall(condense(self, system, ierr))
  end subroutine renew

  !> Computes the components. Where a solve or the elimination fails, self%reason says why. Collective.
  subroutine condense(self, system, ierr)
    class(condensed_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: free_closing(:, :)

    PetscCall(solve_free_response(system, self%linear_solver, system%boundary%n_driving_terms, self%free_response, ierr, self%anchors))
    self%reason = self%linear_solver%reason
    if (self%reason /= reason_converged) return
    PetscCall(close_rows(system, self%free_response, free_closing, ierr))
    self%free_opening = system%rows%gap
    associate (driven => self%free_opening(:, :size(free_closing, 2)))
      driven = driven - free_closing
    end associate
    if (allocated(self%staying_compliance)) then
      PetscCall(solve_compliance(self, system, changing_part, self%compliance, ierr))
      self%compliance = self%compliance + self%staying_compliance
    else
      PetscCall(solve_lifting(system, self%linear_solver, self%lifting, ierr))
      self%reason = self%linear_solver%reason
      if (self%reason /= reason_converged) return
      PetscCall(make_room(self, system, ierr))
      PetscCall(make_compliance(self, system, ierr))
      if (self%reason /= reason_converged) return
      PetscCall(measure_energies(self, system, free_closing, ierr))
    end if
    call close_anchors(self, system)
    ! W is symmetric but for rounding; with anchors its columns are more accurate as they are, where a body is thin
    if (system%motions%n_free == 0) self%compliance = (self%compliance + transpose(self%compliance)) / 2
    if (.not. system%laws%is_plain()) call self%steps%create(system%laws, self%anchors%rows, self%scale, &
      self%compliance, .true.)
  end subroutine condense

  !> Computes W before the anchors are closed: with H, if it is kept, else by elimination, or, where that fails and there is a
  !> factor, some columns at a time. Sets self%reason. Collective.
  subroutine make_compliance(self, system, ierr)
    class(condensed_t), intent(inout) :: self
    type(contact_system_t), intent(in) :: system
    PetscErrorCode, intent(out) :: ierr

    self%reason = reason_linear_solver
    if (.not. allocated(self%contact_response)) then
      PetscCall(eliminate_compliance(self, system, ierr))
    end if
    if (self%reason == reason_converged .or. self%linear_solver%is_multigrid) return
    PetscCall(solve_compliance(self, system, both_parts, self%compliance, ierr))
    self%reason = reason_converged
  end subroutine make_compliance

  !> Computes W before the anchors are closed, and the rows of H that are wanted, without columns of H. Sets self%reason.
  !> Collective.
  subroutine eliminate_compliance(self, system, ierr)
    class(condensed_t), intent(inout) :: self
    type(contact_system_t), intent(in) :: system
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: of_anchors(:, :)

    if (.not. allocated(self%compliance)) allocate (self%compliance(system%rows%n_rows, system%rows%n_rows))
    if (allocated(self%dof_response)) deallocate (self%dof_response)
    allocate (self%dof_response(size(self%elimination%dofs), system%rows%n_rows))
    PetscCall(find_compliance(self, system, ierr))
    if (self%reason /= reason_converged) then
      deallocate (self%dof_response)
      return
    end if
    associate (anchors => self%anchors)
      if (size(anchors%rows) == 0) return
      ! B K^-1 (B' - B_T' N')
      of_anchors = self%compliance(:, anchors%rows)
      call add_product(-1.0_rk, of_anchors, transpose(anchors%closing), self%compliance)
      of_anchors = self%dof_response(:, anchors%rows)
      call add_product(-1.0_rk, of_anchors, transpose(anchors%closing), self%dof_response)
    end associate
  end subroutine eliminate_compliance

  !> Reads B K^-1 B' and the responses of the wanted dofs from the file that keeps them, or eliminates the displacements and writes
  !> this file. Sets self%reason. Collective.
  subroutine find_compliance(self, system, ierr)
    class(condensed_t), intent(inout) :: self
    type(contact_system_t), intent(in) :: system
    PetscErrorCode, intent(out) :: ierr
    logical :: is_there
    integer :: n_ranks, rank
    real(rk) :: found, start

    PetscCall(rank_and_size(system%comm, rank, n_ranks, ierr))
    is_there = .false.
    if (rank == 0) call self%elimination%read_kept(self%compliance, self%dof_response, is_there)
    found = merge(1, 0, is_there)
    PetscCall(max_over_ranks(system%comm, found, ierr))
    if (found > 0) then
      self%reason = reason_converged
      PetscCall(broadcast_columns(self%compliance, system%comm, ierr))
      PetscCall(broadcast_columns(self%dof_response, system%comm, ierr))
      return
    end if
    call self%elimination%announce()
    start = wall_time()
    PetscCall(eliminate_displacements(system, self%elimination%dofs, self%compliance, self%dof_response, self%reason, ierr))
    if (self%reason /= reason_converged) return
    call self%elimination%tell(wall_time() - start)
    ! of several groups of ranks the first one keeps its result
    PetscCall(rank_and_size(PETSC_COMM_WORLD, rank, n_ranks, ierr))
    if (rank == 0) call self%elimination%keep(self%compliance, self%dof_response)
  end subroutine find_compliance

  !> Allocates H if it is to be kept (memory_share). Collective, because ranks may be on different machines.
  subroutine make_room(self, system, ierr)
    class(condensed_t), intent(inout) :: self
    type(contact_system_t), intent(in) :: system
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: n_bytes, share

    n_bytes = storage_size(n_bytes) / 8 * real(system%map%n_dofs, rk) * system%rows%n_rows
    share = n_bytes / machine_memory()
    PetscCall(max_over_ranks(system%comm, share, ierr))
    if (share <= self%memory_share .and. .not. self%linear_solver%is_multigrid) &
      allocate (self%contact_response(system%map%n_local_dofs, system%rows%n_rows))
  end subroutine make_room

  !> Computes W before the anchors are closed, some columns at a time, and H if it is kept. Collective.
  subroutine solve_compliance(self, system, part, compliance, ierr)
    class(condensed_t), intent(inout) :: self
    type(contact_system_t), intent(in) :: system
    !> one of divided_solver_t: whose bodies' W
    integer, intent(in) :: part
    !> [length/force] replicated, shape (n_rows, n_rows)
    real(rk), allocatable, intent(inout) :: compliance(:, :)
    PetscErrorCode, intent(out) :: ierr
    type(progress_t) :: progress
    real(rk), allocatable :: columns(:, :), closing(:, :)
    integer :: first, k, last

    ierr = 0
    if (.not. allocated(compliance)) allocate (compliance(system%rows%n_rows, system%rows%n_rows))
    self%linear_solver%chosen = part
    call progress%start('responses to contact forces', system%rows%n_rows, seconds_of_silence)
    do first = 1, system%rows%n_rows, columns_at_once
      last = min(first + columns_at_once - 1, system%rows%n_rows)
      allocate (columns(system%map%n_local_dofs, last - first + 1))
      PetscCall(solve_columns(system, self%anchors, self%linear_solver, [(k, k=first, last)], columns, ierr))
      PetscCall(close_rows(system, columns, closing, ierr))
      compliance(:, first:last) = closing
      if (allocated(self%contact_response)) self%contact_response(:, first:last) = columns
      deallocate (columns)
      call progress%advance(last)
    end do
    call progress%finish()
    self%linear_solver%chosen = both_parts
  end subroutine solve_compliance

  !> Computes G'K G and H'K G. The forces K G of free dofs are loads, and prescribed displacements cause none; K H = B' - B_T' N' on
  !> these dofs. So H'K G is (B - N B_T) times the displacement that loads cause, which is zero on held dofs. Collective.
  subroutine measure_energies(self, system, free_closing, ierr)
    class(condensed_t), intent(inout) :: self
    type(contact_system_t), intent(in) :: system
    !> [length] B G, shape (n_rows, n_driving_terms)
    real(rk), intent(in) :: free_closing(:, :)
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: lifted(:, :)
    integer :: n

    PetscCall(measure_work(system, self%free_response, self%free_energy, ierr))
    self%shared_energy = free_closing
    n = size(system%boundary%prescribed_values, 2)
    PetscCall(close_rows(system, self%lifting(:, :n), lifted, ierr))
    self%shared_energy(:, :n) = self%shared_energy(:, :n) - lifted
    associate (rows => self%anchors%rows)
      if (size(rows) == 0) return
      self%shared_energy = self%shared_energy - matmul(self%anchors%closing, self%shared_energy(rows, :))
      self%shared_energy(rows, :) = 0
    end associate
  end subroutine measure_energies

  !> Moves the bodies in G and H until the anchors are closed, and makes the openings of the anchors unknowns in place of their
  !> forces. Changes G, H if it is kept, W and D - B G, and sets the scale. Without anchors nothing changes. Local.
  subroutine close_anchors(self, system)
    class(condensed_t), intent(inout) :: self
    type(contact_system_t), intent(in) :: system
    real(rk), allocatable :: opening(:, :), closed(:, :)
    integer :: i

    associate (rows => self%anchors%rows, reach => self%anchors%closing)
      if (size(rows) == 0) return
      call add_columns(self%free_response, size(self%free_opening, 2))
      opening = self%free_opening(rows, :)
      closed = self%compliance(rows, :)
      self%free_opening = self%free_opening - matmul(reach, opening)
      self%compliance = self%compliance - matmul(reach, closed)
      self%scale = sum([(abs(self%compliance(i, i)), i=1, size(self%compliance, 1))]) / size(self%compliance, 1)
      if (self%scale <= 0) self%scale = 1
      call move_bodies(self, system, opening, system%map%local_dofs, self%free_response)
      closed = -closed
      closed(:, rows) = 0
      do i = 1, size(rows)
        closed(i, rows(i)) = self%scale
      end do
      if (allocated(self%contact_response)) then
        self%contact_response(:, rows) = 0
        call move_bodies(self, system, closed, system%map%local_dofs, self%contact_response)
      end if
      if (allocated(self%dof_response)) then
        self%dof_response(:, rows) = 0
        call move_bodies(self, system, closed, self%elimination%dofs, self%dof_response)
      end if
      self%compliance(:, rows) = self%scale * reach
      self%compliance(rows, :) = -self%scale * transpose(reach)
      self%compliance(rows, rows) = 0
      self%free_opening(rows, :) = self%scale * anchor_forces(system, self%anchors)
    end associate
  end subroutine close_anchors

  !> Adds the displacements by which each anchor closes by a given distance and no other anchor moves. Local.
  subroutine move_bodies(self, system, distances, dofs, columns)
    class(condensed_t), intent(in) :: self
    type(contact_system_t), intent(in) :: system
    !> [length] shape (n_anchors, n_columns)
    real(rk), intent(in) :: distances(:, :)
    !> dofs of the rows of `columns`, natural
    integer, intent(in) :: dofs(:)
    !> [length] shape (size(dofs), n_columns)
    real(rk), intent(inout) :: columns(:, :)
    real(rk), allocatable :: motion(:)
    integer :: i, k

    do i = 1, size(distances, 1)
      motion = system%motions%field(self%anchors%amplitudes(:, i))
      motion = motion(dofs)
      do k = 1, size(columns, 2)
        columns(:, k) = columns(:, k) + distances(i, k) * motion
      end do
    end do
  end subroutine move_bodies

  !> Moves the bodies that only contact holds in some displacements, so that all anchors are closed. Requires: create has succeeded.
  !> Collective.
  subroutine hang_bodies(self, system, columns, ierr)
    class(condensed_t), intent(in) :: self
    type(contact_system_t), intent(in) :: system
    !> [length] rows of this rank, shape (n_local_dofs, n_columns)
    real(rk), intent(inout) :: columns(:, :)
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: closing(:, :)

    ierr = 0
    associate (rows => self%anchors%rows)
      if (size(rows) == 0) return
      PetscCall(close_rows(system, columns, closing, ierr))
      call move_bodies(self, system, -closing(rows, :), system%map%local_dofs, columns)
    end associate
  end subroutine hang_bodies

  !> Computes H z for several sets of unknowns: as a product where H is kept, else by one solve for each set. Requires: create has
  !> succeeded. Collective.
  subroutine respond(self, system, unknowns, response, ierr)
    class(condensed_t), intent(inout) :: self
    type(contact_system_t), intent(in) :: system
    !> [force] z: multipliers, and scaled openings of the anchors; shape (n_rows, n_sets)
    real(rk), intent(in) :: unknowns(:, :)
    !> [length] rows of this rank, shape (n_local_dofs, n_sets)
    real(rk), contiguous, intent(out) :: response(:, :)
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: forces(:, :), closing(:, :)

    ierr = 0
    if (allocated(self%contact_response)) then
      response = 0
      call add_product(1.0_rk, self%contact_response, unknowns, response)
      return
    end if
    associate (rows => self%anchors%rows)
      forces = unknowns
      forces(rows, :) = 0
      PetscCall(solve_forces(system, self%anchors, self%linear_solver, forces, response, ierr))
      if (self%linear_solver%reason /= reason_converged) call log_warning('conjugate gradients found no displacement under ' // &
        'contact forces: those of the model, or of this point, are of no use')
      if (size(rows) == 0) return
      PetscCall(close_rows(system, response, closing, ierr))
      call move_bodies(self, system, self%scale * unknowns(rows, :) - closing(rows, :), system%map%local_dofs, response)
    end associate
  end subroutine respond

  !> Returns how many displacements respond should compute at once: one where multigrid solves, which gains nothing with more, so
  !> that progress is told after each.
  pure integer function n_columns_at_once(self) result(n)
    class(condensed_t), intent(in) :: self

    n = merge(1, columns_at_once, self%linear_solver%is_multigrid)
  end function n_columns_at_once

  !> Returns the columns of H that belong to some rows of B. These should come in blocks of n_columns_at_once, so that solves are
  !> fast where H is not kept. Requires: create has succeeded. Collective.
  subroutine respond_to_rows(self, system, chosen, columns, ierr)
    class(condensed_t), intent(inout) :: self
    type(contact_system_t), intent(in) :: system
    !> rows of B, 1-based
    integer, intent(in) :: chosen(:)
    !> [length/force] H(:, chosen), rows of this rank, shape (n_local_dofs, size(chosen))
    real(rk), contiguous, intent(out) :: columns(:, :)
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: unknowns(:, :)
    integer :: i

    ierr = 0
    if (allocated(self%contact_response)) then
      columns = self%contact_response(:, chosen)
      return
    end if
    allocate (unknowns(system%rows%n_rows, size(chosen)), source=0.0_rk)
    do i = 1, size(chosen)
      unknowns(chosen(i), i) = 1
    end do
    PetscCall(self%respond(system, unknowns, columns, ierr))
  end subroutine respond_to_rows

  !> Adds columns of zeros up to n_columns, because gaps that have terms of their own move the bodies that anchors hold.
  pure subroutine add_columns(matrix, n_columns)
    real(rk), allocatable, intent(inout) :: matrix(:, :)
    integer, intent(in) :: n_columns
    real(rk), allocatable :: wider(:, :)

    allocate (wider(size(matrix, 1), n_columns), source=0.0_rk)
    wider(:, :size(matrix, 2)) = matrix
    call move_alloc(wider, matrix)
  end subroutine add_columns

  !> Solves one point, as solve_points does. Collective.
  subroutine solve(self, system, theta, state, ierr)
    class(condensed_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    !> [-] values of the terms, shape (n_terms)
    real(rk), intent(in) :: theta(:)
    type(contact_state_t), intent(out) :: state
    PetscErrorCode, intent(out) :: ierr
    type(contact_state_t) :: states(1)

    PetscCall(self%solve_points(system, reshape(theta, [size(theta), 1]), states, ierr))
    state = states(1)
  end subroutine solve

  !> Returns the number of points that are solved together: about half a second of work, from 4 to 64, and whole histories where
  !> contacts remember. Ranks share the dense
  !> problems, and several displacements take hardly longer than one.
  pure integer function n_points_at_once(self, system) result(n_points)
    class(condensed_t), intent(in) :: self
    type(contact_system_t), intent(in) :: system
    real(rk) :: work

    associate (n_rows => real(system%rows%n_rows, rk))
      work = 2 * system%map%n_dofs * (n_rows + system%boundary%n_driving_terms) + n_rows**3
    end associate
    n_points = nint(max(real(fewest_points_at_once, rk), min(real(most_points_at_once, rk), work_at_once / work)))
    n_points = max(1, n_points / system%n_times) * system%n_times
  end function n_points_at_once

  !> Solves the dense complementarity problem of each point, then computes all displacements together. A point for which no
  !> solution is found has reason_no_complementary_solution, or reason_pulled_off if the loads pull a body off its contacts, or all
  !> have reason_linear_solver if multigrid fails; its forces and displacements are of no use. If `create` has failed, each state
  !> has self%reason, zeros and no closed row. Collective.
  subroutine solve_points(self, system, theta, states, ierr)
    class(condensed_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    !> [-] values of the terms at each point, shape (n_terms, n_points)
    real(rk), intent(in) :: theta(:, :)
    !> shape (n_points)
    type(contact_state_t), intent(out) :: states(:)
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: unknowns(:, :), local(:, :)
    integer :: i

    allocate (unknowns(system%rows%n_rows, size(states)), local(system%map%n_local_dofs, size(states)), source=0.0_rk)
    if (self%reason == reason_converged) then
      PetscCall(solve_multipliers(self, system, theta, states, unknowns, ierr))
      PetscCall(self%respond(system, -unknowns, local, ierr))
      if (self%linear_solver%reason /= reason_converged) states%reason = reason_linear_solver
      call add_product(1.0_rk, self%free_response, theta(:size(self%free_response, 2), :), local)
    else
      do i = 1, size(states)
        states(i)%multipliers = unknowns(:, i)
        states(i)%reason = self%reason
        allocate (states(i)%is_active(system%rows%n_rows), source=.false.)
      end do
    end if
    PetscCall(share_displacements(system, local, states, ierr))
  end subroutine solve_points

  !> Solves the dense problem of each point; each rank solves some of the points. Collective, with the same result on each rank.
  subroutine solve_multipliers(self, system, theta, states, unknowns, ierr)
    type(condensed_t), intent(inout) :: self
    type(contact_system_t), intent(in) :: system
    !> [-] values of the terms, shape (n_terms, n_points)
    real(rk), intent(in) :: theta(:, :)
    !> get reason, n_iterations, multipliers and is_active
    type(contact_state_t), intent(inout) :: states(:)
    !> [force] multipliers, and scaled openings of the anchors; shape (n_rows, n_points)
    real(rk), intent(out) :: unknowns(:, :)
    PetscErrorCode, intent(out) :: ierr
    integer :: i, n_ranks, rank

    PetscCall(rank_and_size(system%comm, rank, n_ranks, ierr))
    unknowns = 0
    if (system%laws%is_plain()) then
      associate (own => [(i, i=rank + 1, size(states), n_ranks)])
        call solve_in_turn(self, theta, own, states, unknowns)
      end associate
    else
      SIG_CHECK(modulo(size(states), system%n_times) == 0, PETSC_ERR_ARG_SIZ, 'a history that is not whole')
      if (.not. allocated(self%latest)) allocate (self%latest(self%steps%n_remembered()))
      self%latest = 0
      call solve_histories(self, system, theta, rank, n_ranks, states, unknowns)
      PetscCall(sum_over_ranks(system%comm, self%latest, ierr))
    end if
    PetscCall(sum_over_ranks(system%comm, unknowns, ierr))
    do i = 1, size(states)
      PetscCall(broadcast_state(states(i), modulo((i - 1) / system%n_times, n_ranks), system%comm, ierr))
    end do
  end subroutine solve_multipliers

  !> Solves the histories that belong to this rank. Local.
  subroutine solve_histories(self, system, theta, rank, n_ranks, states, unknowns)
    type(condensed_t), intent(inout) :: self
    type(contact_system_t), intent(in) :: system
    !> shape (n_terms, n_points); the states of a history follow each other
    real(rk), intent(in) :: theta(:, :)
    integer, intent(in) :: rank
    integer, intent(in) :: n_ranks
    type(contact_state_t), intent(inout) :: states(:)
    !> shape (n_rows, n_points)
    real(rk), intent(inout) :: unknowns(:, :)
    real(rk) :: openings(size(unknowns, 1), size(states)), latest(size(self%latest))
    integer :: first, last

    if (rank * system%n_times >= size(states)) return
    openings = 0
    call add_product(1.0_rk, self%free_opening, theta, openings)
    call balance_anchors(self, theta, openings)
    do first = 1 + rank * system%n_times, size(states), n_ranks * system%n_times
      last = first + system%n_times - 1
      call solve_history(self%steps, self%anchors, openings(:, first:last), theta(:, first:last), self%counts_solutions, &
        states(first:last), unknowns(:, first:last), latest, self%remembered)
      if (last == size(states)) self%latest = latest
    end do
  end subroutine solve_histories

  !> Solves the dense problem of some points. Each one starts from the active set of the last point that was solved. Before there is
  !> one, the start is the pairs that overlap at this point without contact forces, or, if there are anchors, all pairs. Local.
  subroutine solve_in_turn(self, theta, points, states, unknowns)
    type(condensed_t), intent(in) :: self
    real(rk), intent(in) :: theta(:, :)
    !> which points, 1-based
    integer, intent(in) :: points(:)
    type(contact_state_t), intent(inout) :: states(:)
    real(rk), intent(inout) :: unknowns(:, :)
    type(lcp_sizes_t) :: sizes
    type(lcp_solution_t) :: solution
    type(lcp_workspace_t) :: workspace
    real(rk) :: openings(size(unknowns, 1), size(points))
    logical :: start(size(unknowns, 1))
    integer :: i

    if (size(points) == 0) return
    call sizes%create(self%compliance, self%free_opening)
    openings = 0
    call add_product(1.0_rk, self%free_opening, theta(:, points), openings)
    start = openings(:, 1) < 0
    if (size(self%anchors%rows) > 0) then
      ! all pairs closed: that holds the bodies
      start = .true.
      start(self%anchors%rows) = .false.
      call balance_anchors(self, theta(:, points), openings)
    end if
    do i = 1, size(points)
      associate (state => states(points(i)))
        call solve_lcp(self%compliance, openings(:, i), start, solution, workspace)
        state%reason = merge(reason_converged, reason_no_complementary_solution, solution%reason > 0)
        state%n_iterations = solution%n_iterations
        state%multipliers = solution%lambda
        state%is_active = solution%is_active
        unknowns(:, points(i)) = solution%lambda
        if (size(self%anchors%rows) > 0) call load_anchors(self, openings(:, i), solution, state)
        call drop_rounding(sizes, self%compliance, self%free_opening, theta(:, points(i)), self%anchors%rows, self%scale, &
          solution%lambda, state%multipliers)
        ! neighbors in a sweep have nearly the same contact
        if (solution%reason > 0) start = solution%is_active
      end associate
    end do
  end subroutine solve_in_turn

  !> Sets the scaled force of an anchor in `openings` to zero at each point where it is only rounding beside the sizes of its parts,
  !> one per term: there the loads are in equilibrium.
  subroutine balance_anchors(self, theta, openings)
    type(condensed_t), intent(in) :: self
    !> [-] values of the terms, shape (n_terms, n_points)
    real(rk), intent(in) :: theta(:, :)
    !> free openings, in rows of anchors their scaled forces; shape (n_rows, n_points)
    real(rk), intent(inout) :: openings(:, :)

    associate (rows => self%anchors%rows)
      where (abs(openings(rows, :)) <= rounding * matmul(abs(self%free_opening(rows, :)), abs(theta))) openings(rows, :) = 0
    end associate
  end subroutine balance_anchors

  !> Sets the multipliers of the anchors from the solution of the dense problem; an anchor is closed if its opening is zero.
  subroutine load_anchors(self, opening, solution, state)
    type(condensed_t), intent(in) :: self
    !> free openings, in rows of anchors their scaled forces; shape (n_rows)
    real(rk), intent(in) :: opening(:)
    type(lcp_solution_t), intent(in) :: solution
    !> gets multipliers and is_active of the anchors; the reason is reason_pulled_off if the solution has reason_ray
    type(contact_state_t), intent(inout) :: state

    associate (rows => self%anchors%rows)
      state%multipliers(rows) = max(0.0_rk, opening(rows) + matmul(self%compliance(rows, :), solution%lambda)) / self%scale
      state%is_active(rows) = .not. solution%is_active(rows)
    end associate
    if (solution%reason == reason_ray) state%reason = reason_pulled_off
  end subroutine load_anchors

  !> Collects the displacements, of which each rank has its own dofs, on all ranks. Collective.
  subroutine share_displacements(system, local, states, ierr)
    type(contact_system_t), intent(in) :: system
    !> [length] shape (n_local_dofs, n_points)
    real(rk), intent(in) :: local(:, :)
    !> get their displacement
    type(contact_state_t), intent(inout) :: states(:)
    PetscErrorCode, intent(out) :: ierr
    integer :: i, i_local

    ierr = 0
    do i = 1, size(states)
      allocate (states(i)%displacement(system%map%n_dofs), source=0.0_rk)
      do i_local = 1, size(local, 1)
        states(i)%displacement(system%map%local_dofs(i_local)) = local(i_local, i)
      end do
      PetscCall(sum_over_ranks(system%comm, states(i)%displacement, ierr))
    end do
  end subroutine share_displacements

  !> Frees the factor and the arrays. Collective.
  subroutine destroy(self, ierr)
    class(condensed_t), intent(inout) :: self
    PetscErrorCode, intent(out) :: ierr

    if (allocated(self%free_response)) deallocate (self%free_response)
    if (allocated(self%free_opening)) deallocate (self%free_opening)
    if (allocated(self%lifting)) deallocate (self%lifting)
    if (allocated(self%free_energy)) deallocate (self%free_energy, self%shared_energy)
    if (allocated(self%compliance)) deallocate (self%compliance)
    if (allocated(self%staying_compliance)) deallocate (self%staying_compliance)
    if (allocated(self%contact_response)) deallocate (self%contact_response)
    if (allocated(self%dof_response)) deallocate (self%dof_response)
    PetscCall(self%linear_solver%destroy(ierr))
  end subroutine destroy
end module sig_condensed
