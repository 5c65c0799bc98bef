! SPDX-License-Identifier: BSD-3-Clause
!> The energy of contact forces and a bound of their error, from the condensed problem of all contacts.
!>
!> The README of this folder derives the bound.
module sig_condensed_certificate
  use sig_answer, only: answer_t, comparable_size
  use sig_condensed_data, only: condensed_data_t
  use sig_contact_error_bound, only: contact_error_bound_t
  use sig_hanging_bodies, only: hanging_bodies_t
  use sig_kinds, only: rk
  use sig_linear_algebra, only: multiply
  use sig_rounding, only: rounding
  implicit none(type, external)
  private
  public :: condensed_certificate_t

  type :: condensed_certificate_t
    private
    !> rows that are not anchors, 1-based, and W of these rows, factored: it bounds the error of forces in the norm of W
    integer, allocatable :: free_rows(:)
    type(contact_error_bound_t) :: bound
    type(hanging_bodies_t) :: bodies
  contains
    procedure :: create
    procedure :: is_valid
    procedure :: energy
    procedure :: correct
    procedure :: certify
  end type condensed_certificate_t

contains

  !> Factors W of the rows that are not anchors, and copies the data of the anchors. It cannot fail; is_valid says whether there are
  !> bounds.
  subroutine create(self, data)
    class(condensed_certificate_t), intent(inout) :: self
    class(condensed_data_t), intent(in) :: data
    integer :: i, n

    n = size(data%compliance, 1)
    self%free_rows = pack([(i, i=1, n)], [(all(data%anchors /= i), i=1, n)])
    call self%bound%create(data%compliance(self%free_rows, self%free_rows))
    call self%bodies%create(data, self%free_rows)
  end subroutine create

  !> Whether W of the rows that are not anchors is positive definite, so that there are bounds.
  pure logical function is_valid(self)
    class(condensed_certificate_t), intent(in) :: self

    is_valid = self%bound%is_valid
  end function is_valid

  !> Returns the energy E = 1/2 lambda' W lambda + q' lambda [force*length]. Rows of anchors do not count. The result is huge for
  !> forces that do not balance the loads on bodies that only contact holds.
  real(rk) function energy(self, data, theta, multipliers, opening)
    class(condensed_certificate_t), intent(in) :: self
    !> the data that create was called with
    class(condensed_data_t), intent(in) :: data
    !> shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    !> [force] of all contacts, shape (n_multipliers)
    real(rk), contiguous, intent(in) :: multipliers(:)
    !> work array, shape (n_multipliers)
    real(rk), contiguous, intent(inout) :: opening(:)
    real(rk) :: forces(size(multipliers))

    call data%open_freely(theta, opening)
    forces = multipliers
    if (size(data%anchors) > 0) then
      energy = huge(energy)
      if (.not. self%bodies%are_balanced(opening, multipliers)) return
      forces(data%anchors) = 0
    end if
    call multiply(0.5_rk, data%compliance, forces, 1.0_rk, opening)
    energy = dot_product(forces, opening)
  end function energy

  !> Corrects contact forces that another part found. If only contact holds a body and the forces balance the loads, open contacts
  !> lose their forces, and the others are balanced again (sig_hanging_bodies, release). Otherwise, or if the others cannot balance
  !> the loads, the forces do not change.
  subroutine correct(self, data, theta, free_opening, opening, multipliers)
    class(condensed_certificate_t), intent(in) :: self
    !> the data that create was called with
    class(condensed_data_t), intent(in) :: data
    !> shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    !> work arrays, shape (n_multipliers)
    real(rk), contiguous, intent(inout) :: free_opening(:)
    real(rk), contiguous, intent(inout) :: opening(:)
    !> [force] >= 0 of all contacts, shape (n_multipliers)
    real(rk), contiguous, intent(inout) :: multipliers(:)

    if (size(data%anchors) == 0) return
    call open_under(data, theta, multipliers, free_opening, opening)
    if (self%bodies%are_balanced(free_opening, multipliers)) call self%bodies%release(opening(self%free_rows), multipliers)
  end subroutine correct

  !> Bounds the error |lambda_r - lambda| of `multipliers` in the norm of W, by sig_contact_error_bound. This error equals
  !> |u(lambda_r) - u| in the norm of K; with anchors, the rows of the anchors do not count, and u is the elastic part of the
  !> displacement, with closed anchors. If there are anchors, foreign forces (not is_own) that do not balance the loads on the
  !> bodies that only contact holds get the bound huge. Requires: is_valid.
  subroutine certify(self, data, multipliers, is_own, free_opening, opening, answer)
    class(condensed_certificate_t), intent(in) :: self
    !> the data that create was called with
    class(condensed_data_t), intent(in) :: data
    !> [force] >= 0 of all contacts, shape (n_multipliers)
    real(rk), contiguous, intent(in) :: multipliers(:)
    !> whether the condensed problem has just been solved for these forces; free_opening and opening then belong to this solution
    logical, intent(in) :: is_own
    !> [length] q and w = W z + q, shape (n_multipliers); in: of the solution if is_own; otherwise they are computed here
    real(rk), contiguous, intent(inout) :: free_opening(:)
    real(rk), contiguous, intent(inout) :: opening(:)
    !> in: theta, and unknowns where is_own; out: bound and relative_bound
    type(answer_t), intent(inout) :: answer
    real(rk) :: closing(size(self%free_rows)), forces(size(self%free_rows)), place(size(self%free_rows))
    real(rk) :: size_of_answer, surplus

    if (.not. is_own) call open_under(data, answer%theta, multipliers, free_opening, opening)
    place = opening(self%free_rows)
    closing = place - free_opening(self%free_rows)
    if (is_own) call close_anchors(self, data, answer%unknowns, closing)
    forces = multipliers(self%free_rows)
    size_of_answer = comparable_size(sqrt(max(0.0_rk, dot_product(forces, closing))), data%largest_size)
    if (is_own .or. size(data%anchors) == 0) then
      call answer%take_bound(self%bound%evaluate(forces, place, rounding * size_of_answer), size_of_answer)
    else if (self%bodies%are_balanced(free_opening, multipliers)) then
      call self%bodies%settle(multipliers, place, surplus)
      call answer%take_bound(self%bound%evaluate(forces, place, rounding * size_of_answer, surplus), size_of_answer)
    else
      call answer%take_bound(huge(surplus), size_of_answer)
    end if
  end subroutine certify

  !> Computes q (free_opening) and w = W z + q (opening) for forces that another part found, with closed anchors: z is 0 there,
  !> whatever `multipliers` are.
  subroutine open_under(data, theta, multipliers, free_opening, opening)
    class(condensed_data_t), intent(in) :: data
    real(rk), contiguous, intent(in) :: theta(:)
    real(rk), contiguous, intent(in) :: multipliers(:)
    real(rk), contiguous, intent(out) :: free_opening(:)
    real(rk), contiguous, intent(out) :: opening(:)
    real(rk) :: forces(size(multipliers))

    call data%open_freely(theta, free_opening)
    forces = multipliers
    forces(data%anchors) = 0
    opening = free_opening
    call multiply(1.0_rk, data%compliance, forces, 1.0_rk, opening)
  end subroutine open_under

  !> Subtracts from W z the part that the openings of the anchors cause, so that the rest is W z with all anchors closed.
  subroutine close_anchors(self, data, unknowns, closing)
    class(condensed_certificate_t), intent(in) :: self
    class(condensed_data_t), intent(in) :: data
    !> [force] the unknowns z, shape (n_multipliers)
    real(rk), intent(in) :: unknowns(:)
    !> [length] W z on the rows that are not anchors; in: with open anchors; out: with closed ones
    real(rk), intent(inout) :: closing(:)
    integer :: i

    do i = 1, size(data%anchors)
      associate (anchor => data%anchors(i))
        if (unknowns(anchor) > 0) closing = closing - unknowns(anchor) * data%compliance(self%free_rows, anchor)
      end associate
    end do
  end subroutine close_anchors
end module sig_condensed_certificate
