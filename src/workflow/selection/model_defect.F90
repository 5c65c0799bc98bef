! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> The defect of a reduced answer: how far it is from a solution of the full-order problem (3), computed without this solution.
!>
!> If the full-order model can be condensed, the defect is a bound of the energy error. With u(lambda) = G theta - H lambda, which
!> is in equilibrium with the answer's contact forces lambda_r, |u - u_r| <= |u(lambda_r) - u_r| + |u - u(lambda_r)| in the energy
!> norm, and contact_error_bound bounds the last term. G, H and the model's basis are combinations U R of few orthonormal fields U.
!> So a point needs only products with R and U' K U, and small differences keep their digits. Otherwise the defect is the sum of the
!> residuals of (3), which is no bound.
module sig_model_defect
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan, ieee_positive_inf, ieee_quiet_nan, ieee_value
  use sig_condensed, only: condensed_t
  use sig_contact_error_bound, only: contact_error_bound_t
  use sig_contact_residuals, only: measure_points
  use sig_contact_state, only: contact_state_t
  use sig_contact_system, only: contact_system_t
  use sig_kinds, only: rk
  use sig_linear_algebra, only: multiply, transposed_product
  use sig_hhr_data, only: hhr_data_t
  use sig_reasons, only: reason_converged
  use sig_rooms, only: rooms_t
  use sig_model_parts, only: cluster_of
  use sig_online_model, only: online_model_t
  use sig_petsc_support, only: multiply_block, rank_and_size, sum_over_ranks
  use sig_pod, only: compute_pod_of_rows
  use sig_point_solver, only: point_solver_t
  use sig_problem, only: problem_t
  use sig_answer, only: answer_t
  use sig_query, only: query_t
  use sig_reconstruction, only: reconstruct_displacement, reconstruct_multipliers
  use sig_solver_plan, only: fits_condensed
  use petsc
  implicit none(type, external)
  private
  public :: model_defect_t

  !> Call create once; then measure for each model.
  type :: model_defect_t
    !> the full-order model is condensed, and its W is valid for contact_error_bound: the defect is a bound of the energy error
    logical :: is_bound = .false.
    !> these belong to the full order; `condensed` is null if the full-order model is not condensed
    type(contact_system_t), pointer, private :: system => null()
    type(point_solver_t), pointer, private :: solver => null()
    type(problem_t), pointer, private :: problem => null()
    type(condensed_t), pointer, private :: condensed => null()
    type(contact_error_bound_t), private :: contact
    !> R, coordinates of the columns [G, -H, lifting, basis]; the first n_full belong to the full-order model
    real(rk), allocatable, private :: columns(:, :)
    integer, private :: n_full = 0
    !> terms of the model's lifting
    integer, allocatable, private :: lifted_terms(:)
    !> U' K U
    real(rk), allocatable, private :: energy(:, :)
  contains
    procedure :: create
    procedure :: measure
    procedure :: true_errors
    procedure, private :: prepare
    procedure, private :: bound_at
    procedure, private :: energy_norm
  end type model_defect_t

  !> largest number of points whose residuals are measured at a time
  integer, parameter :: chunk = 64
  !> [-] the energy norm by which errors are divided is at least this share of sqrt(|K|) |u|, because u' K u of a rigid motion is
  !> only rounding
  real(rk), parameter :: smallest_share = 1.0e-7_rk

contains

  !> Condenses the full-order model and sets is_bound, if this is possible: the stiffness is fixed and can be factored, supports
  !> hold all bodies, W fits into the memory (fits_condensed) and is positive definite (contact_error_bound). Otherwise is_bound
  !> stays false. Collective on all ranks.
  subroutine create(self, problem, solver, ierr)
    class(model_defect_t), intent(inout) :: self
    !> problem and solver must outlive this object
    type(problem_t), target, intent(in) :: problem
    !> full-order solver of all ranks as one group
    type(point_solver_t), target, intent(inout) :: solver
    PetscErrorCode, intent(out) :: ierr

    ierr = 0
    self%problem => problem
    self%solver => solver
    self%system => solver%system
    ! the bound needs one W for all points
    if (.not. problem%has_fixed_stiffness) return
    ! with anchors the unknowns of W are not the multipliers alone
    if (.not. problem%plan%may_factor .or. self%system%motions%n_free > 0) return
    if (.not. fits_condensed(problem%sizes)) return
    PetscCall(solver%condense(self%condensed, ierr))
    if (self%condensed%reason /= reason_converged) return
    call self%contact%create(self%condensed%compliance)
    self%is_bound = self%contact%is_valid
  end subroutine create

  !> Computes the defects of a model's answers: bound_at with is_bound, otherwise measure_residuals. Infinite where there is no
  !> answer, or where the defect is no number. Collective on all ranks; the result is the same on each. Requires: create.
  subroutine measure(self, online, query, points, defects, ierr)
    class(model_defect_t), intent(inout) :: self
    !> prepared, with one cluster
    type(online_model_t), intent(in) :: online
    !> created for the model
    type(query_t), intent(inout) :: query
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> [-] shape (n_points)
    real(rk), intent(out) :: defects(:)
    PetscErrorCode, intent(out) :: ierr
    type(answer_t) :: answer
    type(rooms_t) :: rooms
    integer :: first, i, last, n_at_once, n_ranks, rank

    defects = 0
    if (self%is_bound) then
      PetscCall(self%prepare(cluster_of(online%model, 1), ierr))
      PetscCall(rank_and_size(PETSC_COMM_WORLD, rank, n_ranks, ierr))
      do i = 1 + rank, size(points, 2), n_ranks
        call query%evaluate(online, points(:, i), answer)
        defects(i) = self%bound_at(online, answer, rooms)
      end do
      PetscCall(sum_over_ranks(PETSC_COMM_WORLD, defects, ierr))
    else
      n_at_once = merge(chunk, 1, self%problem%has_fixed_stiffness)
      do first = 1, size(points, 2), n_at_once
        last = min(first + n_at_once - 1, size(points, 2))
        PetscCall(self%solver%look_at(self%problem, points(:, first), ierr))
        PetscCall(measure_residuals(self%system, online, query, points(:, first:last), defects(first:last), ierr))
      end do
    end if
    ! an answer whose defect is not a number counts as no answer
    where (ieee_is_nan(defects)) defects = ieee_value(1.0_rk, ieee_positive_inf)
  end subroutine measure

  !> Computes orthonormal fields U whose combinations contain all answers of the model and all u(lambda) of the full-order model.
  !> Keeps in self%columns the coordinates R in U of [G, -H, lifting, basis], and in self%energy U' K U. Collective on all ranks.
  !> Requires: is_bound.
  subroutine prepare(self, cluster, ierr)
    class(model_defect_t), intent(inout) :: self
    !> the only cluster of the model
    type(hhr_data_t), intent(in) :: cluster
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: fields(:, :), forces(:, :), own(:, :), sizes(:), values(:), vectors(:, :)
    integer :: i, n_driving, n_lifted, n_rows

    associate (map => self%system%map, local => self%system%map%local_dofs)
      n_driving = size(self%condensed%free_response, 2)
      n_rows = size(self%condensed%compliance, 2)
      n_lifted = size(cluster%lifting, 2)
      self%lifted_terms = cluster%lifted_terms
      self%n_full = n_driving + n_rows
      allocate (fields(map%n_local_dofs, self%n_full + n_lifted + cluster%n_modes))
      fields(:, :n_driving) = self%condensed%free_response
      PetscCall(self%condensed%respond_to_rows(self%system, [(i, i=1, n_rows)], fields(:, n_driving + 1:self%n_full), ierr))
      fields(:, n_driving + 1:self%n_full) = -fields(:, n_driving + 1:self%n_full)
      fields(:, self%n_full + 1:self%n_full + n_lifted) = cluster%lifting(local, :)
      fields(:, self%n_full + n_lifted + 1:) = cluster%basis(local, :)
      ! columns of other units count alike
      sizes = sum(fields**2, dim=1)
      PetscCall(sum_over_ranks(PETSC_COMM_WORLD, sizes, ierr))
      sizes = merge(sqrt(sizes), 1.0_rk, sizes > 0)
      do i = 1, size(sizes)
        fields(:, i) = fields(:, i) / sizes(i)
      end do
      PetscCall(compute_pod_of_rows(fields, map%n_dofs, PETSC_COMM_WORLD, values, vectors, ierr))
      own = vectors(map%first_dof_0 + 1:map%first_dof_0 + map%n_local_dofs, :)
      self%columns = transposed_product(own, fields)
      PetscCall(sum_over_ranks(PETSC_COMM_WORLD, self%columns, ierr))
      do i = 1, size(sizes)
        self%columns(:, i) = self%columns(:, i) * sizes(i)
      end do
      allocate (forces, mold=own)
      PetscCall(multiply_block(self%system%stiffness, own, forces, ierr))
      self%energy = transposed_product(own, forces)
      PetscCall(sum_over_ranks(PETSC_COMM_WORLD, self%energy, ierr))
    end associate
  end subroutine prepare

  !> [-] Returns the bound of the energy error of an answer, divided by the answer's energy norm (at least smallest_share of
  !> sqrt(|K|) |u|, u of the answer); infinite without an answer. By `relative`. Local. Requires: prepare.
  real(rk) function bound_at(self, online, answer, rooms) result(bound)
    class(model_defect_t), intent(in) :: self
    type(online_model_t), intent(in) :: online
    type(answer_t), intent(in) :: answer
    !> work arrays of reconstruct_multipliers
    type(rooms_t), intent(inout) :: rooms
    real(rk) :: multipliers(online%model%n_multipliers), opening(online%model%n_multipliers)
    real(rk) :: reduced(size(self%columns, 1)), balanced(size(self%columns, 1))

    bound = ieee_value(bound, ieee_positive_inf)
    if (answer%reason < 0) return
    call reconstruct_multipliers(online, answer, rooms, multipliers)
    multipliers = max(multipliers, 0.0_rk)
    associate (n_driving => size(self%condensed%free_response, 2))
      call multiply(1.0_rk, self%columns(:, :self%n_full), [answer%theta(:n_driving), multipliers], 0.0_rk, balanced)
      call multiply(1.0_rk, self%columns(:, self%n_full + 1:), [answer%theta(self%lifted_terms), answer%coordinates], 0.0_rk, &
        reduced)
    end associate
    opening = matmul(self%condensed%free_opening, answer%theta) + matmul(self%condensed%compliance, multipliers)
    bound = relative(self%energy_norm(balanced - reduced) + self%contact%evaluate(multipliers, opening), &
      max(self%energy_norm(reduced), smallest_share * sqrt(self%system%stiffness_size) * norm2(reduced)))
  end function bound_at

  !> [sqrt(force*length)] Returns the energy norm of a field that is given by its coordinates in U. Local. Requires: prepare.
  real(rk) function energy_norm(self, coordinates)
    class(model_defect_t), intent(in) :: self
    !> [length] shape (number of the fields U)
    real(rk), contiguous, intent(in) :: coordinates(:)
    real(rk) :: forces(size(coordinates))

    call multiply(1.0_rk, self%energy, coordinates, 0.0_rk, forces)
    energy_norm = sqrt(max(0.0_rk, dot_product(coordinates, forces)))
  end function energy_norm

  !> Computes at each point the sum of three residuals of (3): of equilibrium, relative to the forces; the penetration over the
  !> largest displacement component of the answer (`relative`); of complementarity (relative). Infinite without an answer.
  !> Collective on all ranks. Requires: the system has the stiffness of the points.
  subroutine measure_residuals(system, online, query, points, defects, ierr)
    type(contact_system_t), intent(inout) :: system
    type(online_model_t), intent(in) :: online
    type(query_t), intent(inout) :: query
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> [-] shape (n_points)
    real(rk), intent(out) :: defects(:)
    PetscErrorCode, intent(out) :: ierr
    type(contact_state_t) :: states(size(points, 2))
    type(answer_t) :: answer
    type(rooms_t) :: rooms
    real(rk) :: theta(online%model%terms%n_terms(), size(points, 2))
    logical :: has_answer(size(points, 2))
    integer :: i

    do i = 1, size(states)
      call query%evaluate(online, points(:, i), answer)
      has_answer(i) = answer%reason > 0
      theta(:, i) = answer%theta
      call reconstruct_displacement(online%model, answer, states(i)%displacement)
      allocate (states(i)%multipliers(online%model%n_multipliers))
      call reconstruct_multipliers(online, answer, rooms, states(i)%multipliers)
    end do
    PetscCall(measure_points(system, theta, states, ierr))
    do i = 1, size(states)
      associate (r => states(i)%residuals)
        defects(i) = r%equilibrium + relative(r%penetration, maxval(abs(states(i)%displacement))) + r%complementarity
      end associate
      if (.not. has_answer(i)) defects(i) = ieee_value(defects(i), ieee_positive_inf)
    end do
  end subroutine measure_residuals

  !> Computes the two true errors of an answer at a point. The first is the energy norm of the error of its displacement, which a
  !> bound must not be below. The second is the energy norm of the displacement that the error of its contact forces causes; NaN
  !> without is_bound. Both are divided (`relative`) by the energy norm of the answer (at least smallest_share of sqrt(|K|) |u|, u
  !> of the answer). Collective on all ranks. Requires: create.
  subroutine true_errors(self, point, answered, displacement, answered_multipliers, multipliers, errors, ierr)
    class(model_defect_t), intent(inout) :: self
    !> shape (n_parameters)
    real(rk), intent(in) :: point(:)
    !> [length] displacement of the answer and of the full-order solution, shape (n_dofs)
    real(rk), intent(in) :: answered(:)
    real(rk), intent(in) :: displacement(:)
    !> [force] contact forces of both, shape (n_multipliers)
    real(rk), intent(in) :: answered_multipliers(:)
    real(rk), intent(in) :: multipliers(:)
    !> [-] of the displacement, of the contact forces
    real(rk), intent(out) :: errors(2)
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: difference(size(answered)), forces(size(answered)), whole, wrong(size(multipliers))

    difference = answered - displacement
    PetscCall(self%solver%look_at(self%problem, point, ierr))
    PetscCall(self%system%apply_stiffness(answered, forces, ierr))
    whole = max(sqrt(max(0.0_rk, dot_product(answered, forces))), &
                smallest_share * sqrt(self%system%stiffness_size) * norm2(answered))
    PetscCall(self%system%apply_stiffness(difference, forces, ierr))
    errors(1) = relative(sqrt(max(0.0_rk, dot_product(difference, forces))), whole)
    errors(2) = ieee_value(1.0_rk, ieee_quiet_nan)
    if (.not. self%is_bound) return
    wrong = answered_multipliers - multipliers
    errors(2) = relative(sqrt(max(0.0_rk, dot_product(wrong, matmul(self%condensed%compliance, wrong)))), whole)
  end subroutine true_errors

  !> Returns part / whole; 0 if part is at most 0, otherwise infinite if whole is at most 0.
  pure real(rk) function relative(part, whole)
    real(rk), intent(in) :: part
    real(rk), intent(in) :: whole

    relative = 0
    if (part <= 0) return
    relative = ieee_value(relative, ieee_positive_inf)
    if (whole > 0) relative = part / whole
  end function relative
end module sig_model_defect
