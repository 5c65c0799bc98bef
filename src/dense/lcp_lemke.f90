! SPDX-License-Identifier: BSD-3-Clause
!> Lemke's method (complementary pivoting) with the lexicographic rule, which cannot cycle.
!>
!> The tableau of the equations w - W lambda - d z0 = q is kept in the workspace. Its columns 1 to n belong to w, n + 1 to 2n to
!> lambda, 2n + 1 to z0; the last column has the values of the basic variables.
module sig_lcp_lemke
  use sig_kinds, only: rk
  use sig_lcp_types, only: lcp_workspace_t
  use sig_reasons, only: reason_converged, reason_max_pivots, reason_ray
  implicit none(type, external)
  private
  public :: run_lemke

  !> [-] a pivot of at most this fraction of the largest entry of its column counts as zero
  real(rk), parameter :: pivot_tolerance = 1.0e-10_rk
  !> [-] ratios with at most this relative difference count as equal
  real(rk), parameter :: tie_tolerance = 1.0e-12_rk

contains

  !> Solves lambda >= 0, w = W lambda + q >= 0, lambda' w = 0 by Lemke's method. It follows the path from w = q + d z0, with one
  !> more unknown z0, to z0 = 0, where the problem is solved, or to a ray, where the method has no answer. It makes at most 20 n +
  !> 100 pivots.
  !>
  !> Source: Lemke, Management Science 11 (1965) 681; Cottle, Pang, Stone, The linear complementarity problem, section 4.4.
  !> Requires: at least one q < 0; the covering vector d > 0 in workspace%covering; reserve_tableau. The data are scaled inside, so
  !> units do not matter.
  subroutine run_lemke(matrix, q, workspace, is_active, reason, n_iterations)
    !> W, shape (n, n)
    real(rk), intent(in) :: matrix(:, :)
    !> shape (n)
    real(rk), intent(in) :: q(:)
    !> workspace%lambda is the answer where the problem is solved, else zero
    type(lcp_workspace_t), intent(inout) :: workspace
    !> whether lambda is a basic variable of the answer, shape (n); all false where the problem is not solved
    logical, intent(out) :: is_active(:)
    !> reason_converged, reason_ray or reason_max_pivots
    integer, intent(out) :: reason
    !> number of pivots
    integer, intent(out) :: n_iterations
    integer :: entering, i_row, leaving, max_pivots, n

    n = size(q)
    workspace%lambda(:n) = 0
    is_active = .false.
    call fill_tableau(matrix, q, workspace)
    max_pivots = 20 * n + 100
    entering = 2 * n + 1
    i_row = first_row(workspace, n)
    reason = reason_max_pivots
    do n_iterations = 1, max_pivots
      leaving = workspace%basis(i_row)
      call pivot(workspace, n, i_row, entering)
      if (leaving == 2 * n + 1) then
        call read_solution(matrix, q, workspace, is_active)
        reason = reason_converged
        return
      end if
      entering = complement(leaving, n)
      call find_leaving_row(workspace, n, entering, i_row)
      reason = reason_ray
      if (i_row == 0) return
      reason = reason_max_pivots
    end do
    n_iterations = max_pivots
  end subroutine run_lemke

  !> Returns the largest |W_ij|, by which W is divided in the tableau; the smallest normal number for a matrix of zeros.
  pure real(rk) function matrix_size(matrix)
    real(rk), intent(in) :: matrix(:, :)

    matrix_size = max(maxval(abs(matrix)), tiny(matrix_size))
  end function matrix_size

  !> Fills the tableau with the columns I, -W / matrix_size, -d, and q over its largest |q_i|. The basic variables are w.
  pure subroutine fill_tableau(matrix, q, workspace)
    real(rk), intent(in) :: matrix(:, :)
    real(rk), intent(in) :: q(:)
    type(lcp_workspace_t), intent(inout) :: workspace
    real(rk) :: scale
    integer :: i, n

    n = size(q)
    scale = 1 / matrix_size(matrix)
    do i = 1, n
      workspace%tableau(:n, i) = 0
      workspace%tableau(i, i) = 1
      workspace%tableau(:n, n + i) = -scale * matrix(:, i)
      workspace%basis(i) = i
    end do
    workspace%tableau(:n, 2 * n + 1) = -workspace%covering(:n)
    workspace%tableau(:n, 2 * n + 2) = q / maxval(abs(q))
  end subroutine fill_tableau

  !> Returns the row where z0 enters the basis: the lexicographic minimum of (q_i, e_i) / d_i, which of equal q_i / d_i is the last
  !> row. Every row is then lexicographically positive.
  pure function first_row(workspace, n) result(i_row)
    type(lcp_workspace_t), intent(in) :: workspace
    integer, intent(in) :: n
    integer :: i_row
    real(rk) :: smallest
    integer :: i

    associate (values => workspace%tableau(:n, 2 * n + 2), covering => workspace%covering)
      smallest = huge(smallest)
      do i = 1, n
        smallest = min(smallest, values(i) / covering(i))
      end do
      ! Of equal ratios the last row is the lexicographic minimum: its unit vector starts with more zeros.
      do i_row = n, 1, -1
        if (values(i_row) / covering(i_row) <= smallest + tie_tolerance * abs(smallest)) return
      end do
    end associate
    i_row = 1
  end function first_row

  !> Returns the number of lambda_i for that of w_i, and of w_i for that of lambda_i. The numbers of the variables are i for w_i and
  !> n + i for lambda_i. Requires: the variable is not z0.
  pure function complement(variable, n) result(partner)
    integer, intent(in) :: variable
    integer, intent(in) :: n
    integer :: partner

    partner = merge(variable + n, variable - n, variable <= n)
  end function complement

  !> Finds the row whose basic variable leaves the basis. Of the rows where the entering column is positive by more than rounding,
  !> it is the one with the smallest ratio of the last column over the entering column. Of equal ratios it is the row of z0, because
  !> this ends the path; if z0 is not among them, the columns of w decide in the same way, one after the other (lexicographic rule).
  pure subroutine find_leaving_row(workspace, n, entering, i_leaving)
    type(lcp_workspace_t), intent(inout) :: workspace
    integer, intent(in) :: n
    !> number of the entering variable
    integer, intent(in) :: entering
    !> number of the row; 0 = no entry of the column is positive beyond rounding, and the path is a ray
    integer, intent(out) :: i_leaving
    integer :: i_column, z0_row

    i_leaving = 0
    associate (is_candidate => workspace%is_candidate(:n), column => workspace%tableau(:n, entering))
      is_candidate = column > pivot_tolerance * maxval(abs(column))
      if (.not. any(is_candidate)) return
      call keep_smallest(workspace%tableau(:n, 2 * n + 2), column, is_candidate, workspace%ratio(:n))
      z0_row = findloc(workspace%basis(:n), 2 * n + 1, dim=1)
      if (is_candidate(z0_row)) then
        i_leaving = z0_row
        return
      end if
      ! The columns of w are the inverse of the basis matrix. Its rows differ, so one row is left at the end.
      do i_column = 1, n
        if (count(is_candidate) == 1) exit
        call keep_smallest(workspace%tableau(:n, i_column), column, is_candidate, workspace%ratio(:n))
      end do
      i_leaving = findloc(is_candidate, .true., dim=1)
    end associate
  end subroutine find_leaving_row

  !> Keeps of the candidates only the rows whose ratio numerator / denominator is the smallest of them, within tie_tolerance
  !> (relative where the size of this ratio is above 1, else absolute).
  pure subroutine keep_smallest(numerator, denominator, is_candidate, ratio)
    real(rk), intent(in) :: numerator(:)
    real(rk), intent(in) :: denominator(:)
    logical, intent(inout) :: is_candidate(:)
    !> work space
    real(rk), intent(inout) :: ratio(:)
    real(rk) :: smallest

    where (is_candidate) ratio = numerator / denominator
    smallest = minval(ratio, mask=is_candidate)
    where (is_candidate) is_candidate = ratio <= smallest + tie_tolerance * max(1.0_rk, abs(smallest))
  end subroutine keep_smallest

  !> Makes a Gauss-Jordan step in the whole tableau: the variable number `entering` becomes the basic variable of row i_row.
  pure subroutine pivot(workspace, n, i_row, entering)
    type(lcp_workspace_t), intent(inout) :: workspace
    integer, intent(in) :: n
    integer, intent(in) :: i_row
    integer, intent(in) :: entering
    real(rk) :: factor
    integer :: i_column

    associate (tableau => workspace%tableau, column => workspace%column)
      column(:n) = tableau(:n, entering)
      column(i_row) = 0
      do i_column = 1, 2 * n + 2
        factor = tableau(i_row, i_column) / tableau(i_row, entering)
        if (i_column == entering .or. abs(factor) <= 0) cycle
        tableau(i_row, i_column) = factor
        tableau(:n, i_column) = tableau(:n, i_column) - column(:n) * factor
      end do
      tableau(:n, entering) = 0
      tableau(i_row, entering) = 1
    end associate
    workspace%basis(i_row) = entering
  end subroutine pivot

  !> Reads from the tableau, in their original unit, the lambda that are basic variables, and makes is_active true for them. The
  !> others keep their values. Requires: z0 is no basic variable.
  pure subroutine read_solution(matrix, q, workspace, is_active)
    real(rk), intent(in) :: matrix(:, :)
    real(rk), intent(in) :: q(:)
    type(lcp_workspace_t), intent(inout) :: workspace
    logical, intent(inout) :: is_active(:)
    real(rk) :: unit
    integer :: i_row, k, n

    n = size(q)
    unit = maxval(abs(q)) / matrix_size(matrix)
    do i_row = 1, n
      k = workspace%basis(i_row) - n
      if (k < 1 .or. k > n) cycle
      workspace%lambda(k) = workspace%tableau(i_row, 2 * n + 2) * unit
      is_active(k) = .true.
    end do
  end subroutine read_solution
end module sig_lcp_lemke
