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
  use sig_linear_algebra, only: add_product, transposed_product
  use sig_nnls, only: nnls_t, nnls_workspace_t
  use sig_random_numbers, only: random_t
  implicit none(type, external)
  private
  public :: choose_points, shape_energies

  !> [-] by how much more the energies may miss than the work
  real(rk), parameter :: energy_factor = 100
  !> with more rows, random sums of the rows are fitted in their place
  integer, parameter :: most_rows = 1500
  !> points whose columns are made at once
  integer, parameter :: points_at_once = 512

contains

  !> Chooses points and their shares, by non-negative least squares.
  !>
  !> Time and memory: with n points, m = n_modes * n_directions + n_modes * (n_modes + 1) / 2 sums and k = min(m, most_rows) rows,
  !> the rows take 16 k n bytes and 2 m k n operations, and each chosen point takes about 2 k n operations more.
  subroutine choose_points(points, hooke, stresses, tolerance, shares)
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
    type(nnls_t) :: nnls
    type(nnls_workspace_t) :: workspace
    real(rk), allocatable :: rows(:, :), sums(:)
    real(rk) :: residual

    call fill_rows(points, hooke, stresses, rows)
    sums = sum(rows, dim=2)
    call nnls%prepare(rows)
    deallocate (rows)
    call nnls%solve(sums, workspace, shares, residual, tolerance / max(tolerance, norm2(sums)))
  end subroutine choose_points

  !> Computes what each point adds to the sums, in units in which all sums may miss by the same.
  subroutine fill_rows(points, hooke, stresses, rows)
    type(flow_points_t), intent(in) :: points
    real(rk), intent(in) :: hooke(:, :)
    real(rk), intent(in) :: stresses(:, :)
    !> shape (n_rows, n_points)
    real(rk), allocatable, intent(out) :: rows(:, :)
    real(rk), allocatable :: mixing(:, :), part(:, :)
    real(rk) :: size_of_work
    integer :: first, i, last, n_work

    associate (n_modes => size(points%of_modes, 2), n => size(points%components))
      n_work = n_modes * size(stresses, 2)
      size_of_work = max(tiny(size_of_work), norm2(transposed_product(points%of_modes, stresses)))
      call make_mixing(n_work + n_modes * (n_modes + 1) / 2, mixing)
      allocate (rows(size(mixing, 1), points%n_points()), source=0.0_rk)
      do first = 1, points%n_points(), points_at_once
        last = min(first + points_at_once - 1, points%n_points())
        allocate (part(size(mixing, 2), first:last))
        do i = first, last
          associate (modes => points%of_modes(n * (i - 1) + 1:n * i, :), of_point => stresses(n * (i - 1) + 1:n * i, :))
            part(:n_work, i) = reshape(matmul(transpose(modes), of_point), [n_work]) / size_of_work
          end associate
          part(n_work + 1:, i) = lower_triangle(point_energies(points, hooke, i)) / energy_factor
        end do
        call add_product(1.0_rk, mixing, part, rows(:, first:last))
        deallocate (part)
      end do
    end associate
  end subroutine fill_rows

  !> Makes a matrix of random signs whose products keep the lengths of vectors on average; the unit matrix where there are few rows.
  subroutine make_mixing(n_rows, mixing)
    integer, intent(in) :: n_rows
    !> shape (min(most_rows, n_rows), n_rows)
    real(rk), allocatable, intent(out) :: mixing(:, :)
    type(random_t) :: random
    real(rk) :: draw
    integer :: i, k

    allocate (mixing(min(most_rows, n_rows), n_rows), source=0.0_rk)
    do i = 1, n_rows
      if (n_rows <= most_rows) then
        mixing(i, i) = 1
        cycle
      end if
      do k = 1, most_rows
        call random%fraction(draw)
        mixing(k, i) = sign(1 / sqrt(real(most_rows, rk)), draw - 0.5_rk)
      end do
    end do
  end subroutine make_mixing

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

  !> Returns the sum of E_g' w_g C' E_g over all points, shape (n_modes, n_modes).
  pure function shape_energies(points, hooke) result(energies)
    type(flow_points_t), intent(in) :: points
    real(rk), intent(in) :: hooke(:, :)
    real(rk) :: energies(size(points%of_modes, 2), size(points%of_modes, 2))
    integer :: i

    energies = 0
    do i = 1, points%n_points()
      energies = energies + point_energies(points, hooke, i)
    end do
  end function shape_energies
end module sig_point_choice
