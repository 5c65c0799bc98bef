! SPDX-License-Identifier: BSD-3-Clause
!> The energy of contact forces and bounds of their error and of the displacement's, from the condensed problem of all contacts.
!>
!> The README of this folder derives the bounds.
module sig_condensed_certificate
  use sig_answer, only: answer_t, comparable_size
  use sig_compliance, only: compliance_point_t, compliance_t
  use sig_contact_laws, only: contact_laws_t
  use sig_contact_error_bound, only: contact_error_bound_t
  use sig_force_balance, only: keep_balance
  use sig_friction_steps, only: friction_memory_t
  use sig_free_motions, only: anchor_work
  use sig_hanging_bodies, only: hanging_bodies_t
  use sig_kinds, only: rk
  use sig_linear_algebra, only: multiply
  implicit none(type, external)
  private
  public :: condensed_certificate_t

  type :: condensed_certificate_t
    private
    !> rows that are not anchors, 1-based
    integer, allocatable :: free_rows(:)
    !> of a fixed W: W of these rows, factored; it bounds the error of forces in the norm of W
    type(contact_error_bound_t) :: bound
    !> with a fixed W, those that only contact holds
    type(hanging_bodies_t) :: bodies
  contains
    procedure :: create
    procedure :: is_valid
    procedure :: energy
    procedure :: correct
    procedure :: certify_own
    procedure :: certify_step
    procedure :: certify_foreign
  end type condensed_certificate_t

contains

  !> Factors a fixed W of the rows that are not anchors, and copies the data of the anchors. It cannot fail; is_valid says whether
  !> there are bounds.
  subroutine create(self, compliance)
    class(condensed_certificate_t), intent(inout) :: self
    class(compliance_t), intent(in) :: compliance
    type(compliance_point_t) :: point
    integer :: i, n

    n = compliance%n_rows()
    self%free_rows = pack([(i, i=1, n)], [(all(compliance%anchors /= i), i=1, n)])
    if (.not. (compliance%is_fixed() .and. compliance%has_bound())) return
    call compliance%create_point(point)
    call factor(self, compliance, point, self%bound)
    call self%bodies%create(compliance%anchors, compliance%scale, work_of_anchors(compliance, point))
  end subroutine create

  !> Returns [N; 1], shape (n_multipliers, n_anchors).
  function work_of_anchors(compliance, point) result(work)
    class(compliance_t), target, intent(in) :: compliance
    type(compliance_point_t), target, intent(in) :: point
    real(rk), allocatable :: work(:, :)
    real(rk), pointer, contiguous :: matrix(:, :)

    matrix => compliance%matrix(point)
    work = anchor_work(matrix, compliance%anchors, compliance%scale)
  end function work_of_anchors

  !> Factors W of the rows that are not anchors.
  subroutine factor(self, compliance, point, bound)
    class(condensed_certificate_t), intent(in) :: self
    class(compliance_t), target, intent(in) :: compliance
    type(compliance_point_t), target, intent(in) :: point
    type(contact_error_bound_t), intent(inout) :: bound
    real(rk), pointer, contiguous :: matrix(:, :)

    matrix => compliance%matrix(point)
    if (size(compliance%anchors) == 0) then
      call bound%create(matrix, compliance%least_eigenvalue)
    else
      call bound%create(matrix(self%free_rows, self%free_rows), compliance%least_eigenvalue)
    end if
  end subroutine factor

  !> Whether there are bounds: W has a bound of its own error and, where it is fixed, it is positive definite without the anchors.
  pure logical function is_valid(self, compliance)
    class(condensed_certificate_t), intent(in) :: self
    class(compliance_t), intent(in) :: compliance

    is_valid = compliance%has_bound()
    if (compliance%is_fixed()) is_valid = is_valid .and. self%bound%is_valid
  end function is_valid

  !> Returns the energy E = 1/2 lambda' W lambda + q' lambda [force*length]. Rows of anchors do not count. The result is huge for
  !> forces that do not balance the loads on bodies that only contact holds, and for impossible elastic constants.
  real(rk) function energy(self, compliance, theta, multipliers)
    class(condensed_certificate_t), intent(in) :: self
    !> the one that create was called with
    class(compliance_t), target, intent(in) :: compliance
    !> shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    !> [force] of all contacts, shape (n_multipliers)
    real(rk), contiguous, intent(in) :: multipliers(:)
    type(compliance_point_t), target :: point
    real(rk), pointer, contiguous :: matrix(:, :)
    real(rk) :: forces(size(multipliers))
    logical :: is_possible

    energy = huge(energy)
    call compliance%create_point(point)
    call compliance%evaluate(theta, point, is_possible)
    if (.not. is_possible) return
    if (size(compliance%anchors) > 0) then
      if (.not. keep_balance(work_of_anchors(compliance, point), point%opening(compliance%anchors) / compliance%scale, &
        multipliers)) return
    end if
    forces = compliance%with_closed_anchors(multipliers)
    matrix => compliance%matrix(point)
    call multiply(0.5_rk, matrix, forces, 1.0_rk, point%opening)
    energy = dot_product(forces, point%opening)
  end function energy

  !> Corrects contact forces that another part found. If only contact holds a body and the forces balance the loads, open contacts
  !> lose their forces, and the others are balanced again (sig_hanging_bodies, release). Otherwise, or if the others cannot balance
  !> the loads, the forces do not change.
  subroutine correct(self, compliance, theta, point, opening, multipliers)
    class(condensed_certificate_t), intent(in) :: self
    !> the one that create was called with
    class(compliance_t), target, intent(in) :: compliance
    !> shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    type(compliance_point_t), target, intent(inout) :: point
    !> [length] work array, shape (n_multipliers)
    real(rk), contiguous, intent(inout) :: opening(:)
    !> [force] >= 0 of all contacts, shape (n_multipliers)
    real(rk), contiguous, intent(inout) :: multipliers(:)
    real(rk), pointer, contiguous :: matrix(:, :)
    integer :: i
    logical :: is_possible

    if (size(compliance%anchors) == 0 .or. .not. compliance%is_fixed()) return
    call open_under(compliance, theta, multipliers, point, opening, is_possible)
    if (.not. is_possible) return
    matrix => compliance%matrix(point)
    if (self%bodies%are_balanced(point%opening, multipliers)) call self%bodies%release( &
      [(matrix(self%free_rows(i), self%free_rows(i)), i=1, size(self%free_rows))], opening(self%free_rows), multipliers)
  end subroutine correct

  !> Bounds the error |lambda_r - lambda| of the forces of the problem that has just been solved in the norm of W, by
  !> sig_contact_error_bound where W is fixed, and by what W and q have as errors. This error equals |u(lambda_r) - u| in the norm
  !> of K; with anchors, the rows of the anchors do not count, and u is the elastic part of the displacement, with closed anchors.
  !>
  !> With a displacement, it is bounded, too: |u_r - u|_K <= |u_r - u(lambda_r)|_K + |u(lambda_r) - u|_K, where the first term is
  !> the error of the field under the same forces. Requires: is_valid.
  subroutine certify_own(self, compliance, multipliers, point, opening, answer)
    class(condensed_certificate_t), intent(in) :: self
    !> the one that create was called with
    class(compliance_t), intent(in) :: compliance
    !> [force] >= 0 of all contacts, shape (n_multipliers)
    real(rk), contiguous, intent(in) :: multipliers(:)
    !> with W and q of the solution, and [length] its w = W z + q, shape (n_multipliers)
    type(compliance_point_t), target, intent(in) :: point
    real(rk), contiguous, intent(in) :: opening(:)
    !> in: theta, and unknowns; out: the bounds
    type(answer_t), intent(inout) :: answer
    real(rk) :: bound, closing(size(opening)), size_of_answer, enough

    closing = opening - point%opening
    call close_anchors(compliance, answer%unknowns, point, closing)
    size_of_answer = comparable_size(sqrt(max(0.0_rk, dot_product(multipliers(self%free_rows), closing(self%free_rows)))), &
      compliance%largest_size)
    enough = compliance%rounding() * size_of_answer
    bound = enough
    if (compliance%is_fixed()) bound = self%bound%evaluate(multipliers(self%free_rows), opening(self%free_rows), enough)
    bound = compliance%own_error(answer%theta, answer%unknowns) + bound
    call answer%take_bound(bound, size_of_answer)
    if (compliance%has_displacement()) call compliance%bound_displacement(bound, answer%unknowns, &
      dot_product(answer%unknowns, opening - point%opening), point, answer)
  end subroutine certify_own

  !> Sets the bound of the error of a step with friction or ties, for the places from which its slips count: the size |rho|, in
  !> the norm of W^-1, of a change of gaps and slips for which the answer is exact, over 1 - kappa (sig_friction_contraction).
  !> Where kappa is not known or at least 1, it is |rho| itself, the backward error, which is no bound. Both say nothing of the
  !> errors of earlier steps. Requires: is_valid.
  subroutine certify_step(self, compliance, laws, contraction, memory, point, opening, answer)
    class(condensed_certificate_t), intent(in) :: self
    !> the one that create was called with
    class(compliance_t), intent(in) :: compliance
    type(contact_laws_t), intent(in) :: laws
    !> [-] kappa
    real(rk), intent(in) :: contraction
    !> after the step
    type(friction_memory_t), intent(in) :: memory
    !> with q of the solution, and [length] its w = W z + q, shape (n_multipliers)
    type(compliance_point_t), target, intent(in) :: point
    real(rk), contiguous, intent(in) :: opening(:)
    !> in: theta, unknowns and multipliers; out: the bounds
    type(answer_t), intent(inout) :: answer
    type(contact_error_bound_t) :: norm
    real(rk) :: places(size(opening)), change(size(opening)), closing(size(opening)), size_of_answer, bound

    places = opening
    places(compliance%anchors) = compliance%scale * answer%unknowns(compliance%anchors)
    change = memory%change_to_exact(laws, places)
    closing = opening - point%opening
    call close_anchors(compliance, answer%unknowns, point, closing)
    size_of_answer = comparable_size(sqrt(max(0.0_rk, dot_product(answer%multipliers(self%free_rows), closing(self%free_rows)))), &
      compliance%largest_size)
    if (compliance%is_fixed()) then
      bound = self%bound%dual_size(change(self%free_rows))
    else
      call factor(self, compliance, point, norm)
      if (.not. norm%is_valid) return
      bound = norm%dual_size(change(self%free_rows)) + compliance%own_error(answer%theta, answer%unknowns)
    end if
    if (contraction < 1) bound = bound / (1 - contraction)
    call answer%take_bound(bound, size_of_answer)
    if (compliance%has_displacement()) call compliance%bound_displacement(bound, answer%unknowns, &
      dot_product(answer%unknowns, opening - point%opening), point, answer)
  end subroutine certify_step

  !> Bounds the error of forces that another part found, in the norm of W. If there are anchors, forces that do not balance the
  !> loads on the bodies that only contact holds get the bound huge; where W is not fixed, too, nothing changes. Requires: is_valid.
  !>
  !> The bound of the problem with W counts foreign_factor times: it is assumed that the norms of the true W and of this one differ
  !> by no more.
  subroutine certify_foreign(self, compliance, multipliers, point, opening, answer)
    class(condensed_certificate_t), intent(in) :: self
    !> the one that create was called with
    class(compliance_t), target, intent(in) :: compliance
    !> [force] >= 0 of all contacts, shape (n_multipliers)
    real(rk), contiguous, intent(in) :: multipliers(:)
    !> work arrays
    type(compliance_point_t), target, intent(inout) :: point
    real(rk), contiguous, intent(inout) :: opening(:)
    !> in: theta; out: bound and relative_bound
    type(answer_t), intent(inout) :: answer
    type(contact_error_bound_t) :: norm
    real(rk) :: bound, forces(size(self%free_rows)), place(size(self%free_rows)), size_of_answer, surplus
    logical :: is_possible

    if (size(compliance%anchors) > 0 .and. .not. compliance%is_fixed()) return
    call open_under(compliance, answer%theta, multipliers, point, opening, is_possible)
    if (.not. is_possible) return
    place = opening(self%free_rows)
    forces = multipliers(self%free_rows)
    size_of_answer = comparable_size(sqrt(max(0.0_rk, dot_product(forces, place - point%opening(self%free_rows)))), &
      compliance%largest_size)
    bound = huge(bound)
    surplus = 0
    associate (enough => compliance%rounding() * size_of_answer)
      if (size(compliance%anchors) > 0) then
        if (self%bodies%are_balanced(point%opening, multipliers)) then
          call self%bodies%settle(multipliers, place, surplus)
          bound = self%bound%evaluate(forces, place, enough, surplus)
        end if
      else if (compliance%is_fixed()) then
        bound = self%bound%evaluate(forces, place, enough)
      else
        call factor(self, compliance, point, norm)
        if (norm%is_valid) bound = compliance%foreign_factor() * norm%evaluate(forces, place, enough) + &
          compliance%own_error(answer%theta, multipliers)
      end if
    end associate
    call answer%take_bound(bound, size_of_answer)
  end subroutine certify_foreign

  !> Computes q (in `point`) and w = W z + q (opening) for forces that another part found, with closed anchors: z is 0 there,
  !> whatever `multipliers` are.
  subroutine open_under(compliance, theta, multipliers, point, opening, is_possible)
    class(compliance_t), target, intent(in) :: compliance
    real(rk), contiguous, intent(in) :: theta(:)
    real(rk), contiguous, intent(in) :: multipliers(:)
    type(compliance_point_t), target, intent(inout) :: point
    real(rk), contiguous, intent(inout) :: opening(:)
    !> false: elastic constants are impossible, and nothing is computed
    logical, intent(out) :: is_possible
    real(rk), pointer, contiguous :: matrix(:, :)

    call compliance%evaluate(theta, point, is_possible)
    if (.not. is_possible) return
    matrix => compliance%matrix(point)
    opening = point%opening
    call multiply(1.0_rk, matrix, compliance%with_closed_anchors(multipliers), 1.0_rk, opening)
  end subroutine open_under

  !> Subtracts from W z the part that the openings of the anchors cause, so that the rest is W z with all anchors closed.
  subroutine close_anchors(compliance, unknowns, point, closing)
    class(compliance_t), target, intent(in) :: compliance
    !> [force] the unknowns z, shape (n_multipliers)
    real(rk), intent(in) :: unknowns(:)
    type(compliance_point_t), target, intent(in) :: point
    !> [length] W z; in: with open anchors; out: with closed ones, except in the rows of anchors
    real(rk), intent(inout) :: closing(:)
    real(rk), pointer, contiguous :: matrix(:, :)
    integer :: i

    matrix => compliance%matrix(point)
    do i = 1, size(compliance%anchors)
      associate (anchor => compliance%anchors(i))
        if (unknowns(anchor) > 0) closing = closing - unknowns(anchor) * matrix(:, anchor)
      end associate
    end do
  end subroutine close_anchors
end module sig_condensed_certificate
