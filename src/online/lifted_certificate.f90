! SPDX-License-Identifier: BSD-3-Clause
!> The error bound of a hyper-reduced model that does not keep the matrix W of all contacts.
!>
!> The model's forces are a combination of the snapshots' forces and of unit forces on rows of its domain, and so are the openings W
!> lambda. Forces that were changed afterwards have no bound.
module sig_lifted_certificate
  use sig_answer, only: answer_t, comparable_size
  use sig_force_balance, only: keep_balance
  use sig_hhr_data, only: hhr_data_t
  use sig_kinds, only: rk
  use sig_lifted_error_bound, only: lifted_error_bound_t
  use sig_linear_algebra, only: multiply, solve_dense
  use sig_multiplier_fit, only: work_of_loads
  implicit none(type, external)
  private
  public :: lifted_certificate_t

  type :: lifted_certificate_t
    logical :: is_there = .false.
    type(lifted_error_bound_t) :: bound
  contains
    procedure :: prepare
    procedure :: certify
  end type lifted_certificate_t

  !> [-] rounding error of a sum of forces, relative to the largest force
  real(rk), parameter :: rounding = 1.0e-13_rk

contains

  !> Prepares the bound. is_there says afterwards whether the cluster has the data for it.
  subroutine prepare(self, cluster)
    class(lifted_certificate_t), intent(inout) :: self
    type(hhr_data_t), intent(in) :: cluster

    self%is_there = cluster%certificate%is_there()
    if (.not. self%is_there) return
    associate (data => cluster%certificate)
      call self%bound%create(data%pattern_forces, data%pattern_opening, cluster%motion_closing, data%lift, reach_of(cluster))
    end associate
  end subroutine prepare

  !> Returns an estimate [length/force] of the diagonal of W, shape (n_multipliers): a factor over the diagonal of L'KL. The factor
  !> is the mean, over the rows of the domain, of the product of both diagonals; there W is known.
  pure function reach_of(cluster) result(reach)
    type(hhr_data_t), intent(in) :: cluster
    real(rk), allocatable :: reach(:)
    real(rk) :: factor
    integer :: i

    reach = cluster%certificate%lift%diagonal()
    factor = 0
    do i = 1, cluster%n_rows
      associate (row => cluster%contact_rows(i))
        factor = factor + reach(row) * cluster%certificate%row_opening(row, i) / cluster%n_rows
      end associate
    end do
    reach = factor / max(reach, tiny(factor))
  end function reach_of

  !> Bounds the error of an answer's forces on all contacts. There is no bound if the forces outside of the domain are not the
  !> combination of the snapshots with these coefficients, except for rounding. The bound is huge if the forces do not balance the
  !> loads on bodies that only contact holds.
  !> Requires: is_there.
  subroutine certify(self, cluster, coefficients, multipliers, answer)
    class(lifted_certificate_t), intent(in) :: self
    !> the data that prepare was called with
    type(hhr_data_t), intent(in) :: cluster
    !> [-] coefficients >= 0 of the snapshots that gave the forces outside of the domain; shape (n_snapshots)
    real(rk), contiguous, intent(in) :: coefficients(:)
    !> [force] >= 0 of all contacts, shape (n_multipliers)
    real(rk), contiguous, intent(in) :: multipliers(:)
    !> in: theta; out: bound and relative_bound, which do not change where there is no bound
    type(answer_t), intent(inout) :: answer
    real(rk) :: closing(size(multipliers)), opening(size(multipliers)), rest(size(multipliers)), size_of_answer

    associate (data => cluster%certificate)
      rest = multipliers
      call multiply(-1.0_rk, cluster%dual_snapshots, coefficients, 1.0_rk, rest)
      call multiply(1.0_rk, data%snapshot_opening, coefficients, 0.0_rk, closing)
      call multiply(1.0_rk, data%row_opening, rest(cluster%contact_rows), 1.0_rk, closing)
      rest(cluster%contact_rows) = 0
      if (any(abs(rest) > rounding * maxval(multipliers))) return
      call multiply(1.0_rk, data%free_opening, answer%theta, 0.0_rk, opening)
      opening = opening + closing
      size_of_answer = comparable_size(size_of(cluster, multipliers, closing), data%largest_size)
    end associate
    if (keep_balance(cluster%motion_closing, work_of_loads(cluster, answer%theta), multipliers)) then
      call answer%take_bound(self%bound%evaluate(multipliers, opening), size_of_answer)
    else
      call answer%take_bound(huge(size_of_answer), size_of_answer)
    end if
  end subroutine certify

  !> Returns the size of forces [sqrt(force*length)] in the norm of W: the square root of their work on the openings that they
  !> cause, with closed anchors.
  real(rk) function size_of(cluster, multipliers, closing)
    type(hhr_data_t), intent(in) :: cluster
    real(rk), intent(in) :: multipliers(:)
    !> [length] W lambda; the rigid motions that close the anchors are added here
    real(rk), intent(in) :: closing(:)
    real(rk) :: place(size(cluster%motion_closing, 2)), work
    logical :: is_singular

    work = dot_product(multipliers, closing)
    associate (motions => cluster%motion_closing, anchors => cluster%certificate%anchors)
      call solve_dense(motions(anchors, :), -closing(anchors), place, is_singular)
      work = work + dot_product(matmul(multipliers, motions), place)
    end associate
    size_of = sqrt(max(0.0_rk, work))
  end function size_of
end module sig_lifted_certificate
