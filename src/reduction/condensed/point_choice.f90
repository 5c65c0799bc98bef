! SPDX-License-Identifier: BSD-3-Clause
!> Chooses a few integration points, with weights, that stand for all in a reduced model of materials that flow.
!>
!> With E_g the strains of the inelastic modes at point g, the sums over the chosen points are those over all points of
!>
!>   - the work E_g' w_g s_g of the stresses s that inelastic strains take away in training, and
!>   - the stiffness E_g' w_g C' E_g, where C' is the elastic stiffness against changes of shape.
!>
!> The second matters where much flows: Newton's method has the matrix I - sum E_g' w_g T_g E_g, and T_g, the share of the stiffness
!> that flow takes away, is between 0 and C', because flow keeps the volume. Over all points the sum is at most I: this is the
!> energy of the modes, which are orthonormal. Points that fit the work alone have sums of up to 1.3 I, so that equilibria are lost.
module sig_point_choice
  use sig_elasticity, only: n_stresses
  use sig_flow_points, only: flow_points_t
  use sig_kinds, only: rk
  use sig_linear_algebra, only: transposed_product
  use sig_nnls, only: nnls_t, nnls_workspace_t
  use sig_random_numbers, only: random_t
  implicit none(type, external)
  private
  public :: choose_points, most_rows, share_missed

  !> [-] by how much more the energies may miss than the work
  real(rk), parameter :: energy_factor = 100
  !> with more sums than most_rows, so many random sums of them are fitted in their place, each sum being part of rows_of_a_sum
  integer, parameter :: most_rows = 1500, rows_of_a_sum = 8

contains

  !> Chooses points and their shares, by non-negative least squares. Where random sums are fitted, share_missed says how well they
  !> stand for the others.
  !>
  !> Memory and time: with n points and k = most_rows rows at most, these take 16 k n bytes, and each chosen point about 2 k n
  !> operations. That is 1.4 GB for 60 000 points, and a minute for 300 of them.
  subroutine choose_points(points, hooke, stresses, tolerance, shares, strains)
    type(flow_points_t), intent(in) :: points
    !> [force/length**2] elastic stress per strain of each material, shape (n_stresses, n_stresses * n_materials)
    real(rk), intent(in) :: hooke(:, :)
    !> [force, force/length] main directions of the stresses that inelastic strains take away, times the volumes of the points, each
    !> with its size; shape (n_strains * n_points, n_directions)
    real(rk), intent(in) :: stresses(:, :)
    !> [-] the chosen points miss the work over all points by at most about this share of its size, and the energies of the modes,
    !> at most 1, by energy_factor times this
    real(rk), intent(in) :: tolerance
    !> [-] by how much the weight of each point is multiplied; 0 = not chosen; shape (n_points)
    real(rk), intent(out) :: shares(:)
    !> further strains the work on which counts as that on the modes, shape (n_strains * n_points, n_columns)
    real(rk), intent(in), optional :: strains(:, :)
    type(nnls_t) :: nnls
    type(nnls_workspace_t) :: workspace
    real(rk), allocatable :: rows(:, :), sums(:)
    real(rk) :: residual

    call fill_rows(points, hooke, stresses, rows, strains)
    sums = sum(rows, dim=2)
    call nnls%prepare(rows)
    deallocate (rows)
    call nnls%solve(sums, workspace, shares, residual, tolerance / max(tolerance, norm2(sums)))
  end subroutine choose_points

  !> Computes what each point adds to the sums, in units in which all sums may miss by the same.
  subroutine fill_rows(points, hooke, stresses, rows, strains)
    type(flow_points_t), intent(in) :: points
    real(rk), intent(in) :: hooke(:, :)
    real(rk), intent(in) :: stresses(:, :)
    !> shape (n_rows, n_points)
    real(rk), allocatable, intent(out) :: rows(:, :)
    real(rk), intent(in), optional :: strains(:, :)
    integer, allocatable :: places(:, :)
    real(rk), allocatable :: factors(:, :), part(:)
    real(rk) :: size_on_modes, size_on_strains
    integer :: i, n_further

    n_further = 0
    if (present(strains)) n_further = size(strains, 2)
    associate (n_modes => size(points%of_modes, 2), n => size(points%components))
      call make_mixing((n_modes + n_further) * size(stresses, 2) + n_modes * (n_modes + 1) / 2, places, factors)
      allocate (rows(maxval([1, maxval(places)]), points%n_points()), source=0.0_rk)
      size_on_modes = max(tiny(1.0_rk), norm2(transposed_product(points%of_modes, stresses)))
      if (present(strains)) size_on_strains = max(tiny(1.0_rk), norm2(transposed_product(strains, stresses)))
      do i = 1, points%n_points()
        associate (first => n * (i - 1) + 1, last => n * i)
          part = [work_of(points%of_modes(first:last, :), stresses(first:last, :)) / size_on_modes, &
            lower_triangle(point_energies(points, hooke, i)) / energy_factor]
          if (present(strains)) part = [part, work_of(strains(first:last, :), stresses(first:last, :)) / size_on_strains]
        end associate
        call add_mixed(part, places, factors, rows(:, i))
      end do
    end associate
  end subroutine fill_rows

  !> Returns the work of each stress on each strain of a point.
  pure function work_of(strains, stresses) result(work)
    !> shapes (n_strains, n_columns) and (n_strains, n_directions)
    real(rk), intent(in) :: strains(:, :)
    real(rk), intent(in) :: stresses(:, :)
    real(rk) :: work(size(strains, 2) * size(stresses, 2))

    work = reshape(matmul(transpose(strains), stresses), [size(work)])
  end function work_of

  !> Makes each sum a row of its own, or, where these were too many, part of rows_of_a_sum rows, with random signs: lengths are then
  !> kept on average.
  subroutine make_mixing(n_sums, places, factors)
    integer, intent(in) :: n_sums
    !> rows of each sum, and the factors that it has there; shape (., n_sums)
    integer, allocatable, intent(out) :: places(:, :)
    real(rk), allocatable, intent(out) :: factors(:, :)
    type(random_t) :: random
    real(rk) :: draw
    integer :: i, k

    if (n_sums <= most_rows) then
      places = reshape([(i, i=1, n_sums)], [1, n_sums])
      allocate (factors(1, n_sums), source=1.0_rk)
      return
    end if
    allocate (places(rows_of_a_sum, n_sums), factors(rows_of_a_sum, n_sums))
    do i = 1, n_sums
      do k = 1, rows_of_a_sum
        call random%fraction(draw)
        places(k, i) = 1 + int(draw * most_rows)
        call random%fraction(draw)
        factors(k, i) = sign(1 / sqrt(real(rows_of_a_sum, rk)), draw - 0.5_rk)
      end do
    end do
  end subroutine make_mixing

  !> Adds sums to the rows that they are part of.
  pure subroutine add_mixed(sums, places, factors, rows)
    real(rk), intent(in) :: sums(:)
    integer, intent(in) :: places(:, :)
    real(rk), intent(in) :: factors(:, :)
    real(rk), intent(inout) :: rows(:)
    integer :: i, k

    do i = 1, size(sums)
      do k = 1, size(places, 1)
        rows(places(k, i)) = rows(places(k, i)) + factors(k, i) * sums(i)
      end do
    end do
  end subroutine add_mixed

  !> Returns the entries of the lower triangle of a symmetric matrix, with the same sum of squares as all entries.
  pure function lower_triangle(matrix) result(entries)
    real(rk), intent(in) :: matrix(:, :)
    real(rk) :: entries(size(matrix, 1) * (size(matrix, 1) + 1) / 2)
    integer :: i, n

    n = 0
    do i = 1, size(matrix, 1)
      entries(n + 1) = matrix(i, i)
      entries(n + 2:n + 1 + size(matrix, 1) - i) = sqrt(2.0_rk) * matrix(i + 1:, i)
      n = n + 1 + size(matrix, 1) - i
    end do
  end function lower_triangle

  !> Returns E_g' w_g C' E_g of one point, shape (n_modes, n_modes).
  pure function point_energies(points, hooke, i_point) result(energies)
    type(flow_points_t), intent(in) :: points
    real(rk), intent(in) :: hooke(:, :)
    integer, intent(in) :: i_point
    real(rk) :: energies(size(points%of_modes, 2), size(points%of_modes, 2))
    real(rk) :: stiffness(n_stresses, n_stresses)

    stiffness = hooke(:, n_stresses * (points%materials(i_point) - 1) + 1:n_stresses * points%materials(i_point))
    ! without what resists a change of volume
    stiffness(:3, :3) = stiffness(:3, :3) - sum(stiffness(:3, :3)) / 9
    associate (n => size(points%components), c => points%components)
      associate (strains => points%of_modes(n * (i_point - 1) + 1:n * i_point, :))
        energies = points%weights(i_point) * matmul(transpose(strains), matmul(stiffness(c, c), strains))
      end associate
    end associate
  end function point_energies
  !> [-] Returns which share of the work of stresses on strains over all points chosen ones miss.
  real(rk) function share_missed(strains, stresses, shares)
    !> shapes (n_strains * n_points, n_columns) and (n_strains * n_points, n_directions)
    real(rk), intent(in) :: strains(:, :)
    real(rk), intent(in) :: stresses(:, :)
    !> of each point, shape (n_points)
    real(rk), intent(in) :: shares(:)
    real(rk), allocatable :: missed(:, :)
    integer :: i, n

    missed = stresses
    n = size(stresses, 1) / max(1, size(shares))
    do i = 1, size(shares)
      missed(n * (i - 1) + 1:n * i, :) = (1 - shares(i)) * missed(n * (i - 1) + 1:n * i, :)
    end do
    share_missed = norm2(transposed_product(strains, missed)) / &
      max(tiny(1.0_rk), norm2(transposed_product(strains, stresses)))
  end function share_missed
end module sig_point_choice
