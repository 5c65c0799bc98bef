! SPDX-License-Identifier: BSD-3-Clause
!> Values of the terms theta_t at parameter points, from their texts.
module sig_terms
  use sig_expression, only: expression_t
  use sig_kinds, only: rk
  use sig_text, only: string_t
  implicit none(type, external)
  private
  public :: evaluate_terms

contains

  !> theta(n_terms, n_points). The deck layer checked the texts; a value that is not finite at a point is left to the caller.
  subroutine evaluate_terms(texts, parameter_names, points, theta, i_bad_point)
    type(string_t), intent(in) :: texts(:)
    type(string_t), intent(in) :: parameter_names(:)
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> [-] shape (n_terms, n_points)
    real(rk), allocatable, intent(out) :: theta(:, :)
    !> first point where a term has no finite value; 0 = none
    integer, intent(out) :: i_bad_point
    type(expression_t) :: expression
    character(:), allocatable :: message
    integer :: i_term, i_point
    logical :: is_valid

    i_bad_point = 0
    allocate (theta(size(texts), size(points, 2)), source=0.0_rk)
    do i_term = 1, size(texts)
      call expression%create(texts(i_term)%text, parameter_names, message)
      do i_point = 1, size(points, 2)
        call expression%evaluate(points(:, i_point), theta(i_term, i_point), is_valid)
        if (.not. is_valid .and. i_bad_point == 0) i_bad_point = i_point
      end do
      call expression%destroy()
    end do
  end subroutine evaluate_terms
end module sig_terms
