! SPDX-License-Identifier: BSD-3-Clause
!> Motions in which bodies slip on each other, such as a round disc that rotates between two plates. Only the facets of the mesh
!> resist them: the normals of a row that come from facets are not quite radial, and contact forces would then have to balance
!> moments that the real, round surfaces do not have. We turn the normals of the rows until the motions change no gap at all.
!>
!> A motion slips if at each row the relative velocity of both sides is tangential to the smooth surface, up to the angle to which
!> its normal is certain (sig_smooth_normals). Slippage analysis of surfaces: Gelfand and Guibas, Symposium on Geometry Processing
!> 2004.
module sig_slipping_motions
  use sig_contact_rows, only: contact_rows_t
  use sig_kinds, only: rk
  use sig_rigid_bodies, only: null_space
  use sig_rigid_motions, only: rigid_motions_t
  use sig_rounding, only: rounding_of_data
  use sig_singular_values, only: svd
  use sig_smooth_normals, only: normal_of_row
  implicit none(type, external)
  private
  public :: turn_normals

  !> [-] a single row may miss the tangent by so many times the error of its normal
  real(rk), parameter :: margin = 3.0_rk
  !> [-] velocities are parallel if they span a second direction by at most this share
  real(rk), parameter :: parallel = 1.0e-4_rk
  !> [-] normal components of velocities up to this one are rounding, after at most so many rounds
  real(rk), parameter :: tangential = 1.0e-13_rk
  integer, parameter :: most_rounds = 200

contains

  !> Turns the normals of the rows that slip. Nothing changes if no motion slips, or if the normals do not settle.
  subroutine turn_normals(motions, normals, errors, rows, misses, is_settled)
    !> free motions of these rows, of create_free_motions
    type(rigid_motions_t), intent(in) :: motions
    !> smooth normals of the rows and their errors [rad], of fit_normals
    real(rk), intent(in) :: normals(:, :), errors(:)
    type(contact_rows_t), intent(inout) :: rows
    !> [rad] angle by which the slipping motions of each body miss the tangents of its rows, root mean square; 0 for bodies that do
    !> not slip; shape (n_bodies)
    real(rk), intent(out) :: misses(:)
    !> false if motions slip, but no normals were found that let them: facets resist them then
    logical, intent(out) :: is_settled
    type(contact_rows_t) :: turned
    real(rk), allocatable :: slips(:, :), velocities(:, :, :)
    integer :: k

    is_settled = .true.
    misses = 0
    if (motions%n_free == 0 .or. rows%n_rows == 0) return
    allocate (velocities(rows%n_dim, motions%n_free, rows%n_rows))
    do k = 1, rows%n_rows
      velocities(:, :, k) = relative_velocity(motions, rows, k)
    end do
    call find_slips(velocities, normals, errors, slips)
    if (size(slips, 2) == 0) return
    turned = rows
    call settle(velocities, turned, slips, is_settled)
    if (.not. is_settled) return
    rows = turned
    call measure_misses(motions, rows, velocities, normals, slips, misses)
  end subroutine turn_normals

  !> Turns the normals across the velocities of the motions, and takes as new motions those that these normals resist least, until
  !> they do not resist any more: three rotations of a ball then have one center. Normals that do not resist stay bit by bit.
  subroutine settle(velocities, rows, slips, is_settled)
    !> shape (n_dim, n_free, n_rows)
    real(rk), intent(in) :: velocities(:, :, :)
    type(contact_rows_t), intent(inout) :: rows
    !> shape (n_free, n)
    real(rk), intent(inout) :: slips(:, :)
    !> false if they still resist after most_rounds
    logical, intent(out) :: is_settled
    real(rk) :: across(size(slips, 1), size(slips, 1)), row(size(slips, 1)), normal(rows%n_dim), largest
    real(rk), allocatable :: u(:, :), s(:), vt(:, :)
    integer :: i_round, k, n

    do i_round = 0, most_rounds
      across = 0
      largest = 0
      do k = 1, rows%n_rows
        normal = normal_of_row(rows, k)
        row = matmul(normal, velocities(:, :, k)) / norm2(normal)
        across = across + spread(row, 2, size(row)) * spread(row, 1, size(row))
        largest = max(largest, norm2(matmul(row, slips)))
      end do
      is_settled = largest <= tangential
      if (is_settled .or. i_round == most_rounds) return
      if (i_round > 0) then
        call svd(across, u, s, vt)
        n = size(slips, 2)
        slips = transpose(vt(size(s) - n + 1:, :))
      end if
      do k = 1, rows%n_rows
        call turn_row(matmul(velocities(:, :, k), slips), rows, k)
      end do
    end do
  end subroutine settle

  !> Returns the velocity of the first side relative to the second one in each free motion, with the weights of the row; shape
  !> (n_dim, n_free).
  pure function relative_velocity(motions, rows, k) result(velocity)
    type(rigid_motions_t), intent(in) :: motions
    type(contact_rows_t), intent(in) :: rows
    integer, intent(in) :: k
    real(rk) :: velocity(rows%n_dim, motions%n_free)
    real(rk) :: normal(rows%n_dim)
    integer :: i

    normal = normal_of_row(rows, k)
    normal = normal / sum(normal**2)
    velocity = 0
    associate (nodes => rows%nodes_of(k), from => rows%offsets(k))
      do i = 1, size(nodes)
        velocity = velocity + motions%at_node(nodes(i)) * &
          dot_product(normal, rows%coefficients(from + rows%n_dim * (i - 1) + 1:from + rows%n_dim * i))
      end do
    end associate
  end function relative_velocity

  !> Finds a basis of the slipping motions: first those that miss the tangents by less than the errors in the mean over all rows,
  !> then only combinations that do so at each row.
  subroutine find_slips(velocities, normals, errors, slips)
    !> shape (n_dim, n_free, n_rows)
    real(rk), intent(in) :: velocities(:, :, :)
    real(rk), intent(in) :: normals(:, :), errors(:)
    !> [-] amplitudes of the free motions, orthonormal, shape (n_free, n)
    real(rk), allocatable, intent(out) :: slips(:, :)
    real(rk) :: across(size(velocities, 2), size(velocities, 2)), whole(size(velocities, 2), size(velocities, 2))
    real(rk), allocatable :: u(:, :), s(:), vt(:, :), missing(:, :)
    integer :: i, k

    across = 0
    whole = 0
    do k = 1, size(errors)
      associate (velocity => velocities(:, :, k), row => matmul(normals(:, k), velocities(:, :, k)) / errors(k))
        across = across + spread(row, 2, size(row)) * spread(row, 1, size(row))
        whole = whole + matmul(transpose(velocity), velocity)
      end associate
    end do
    call svd(across, u, s, vt)
    slips = transpose(vt(pack([(i, i=1, size(s))], [(s(i) <= dot_product(vt(i, :), matmul(whole, vt(i, :))), i=1, size(s))]), :))
    do while (size(slips, 2) > 0)
      call find_missing(velocities, normals, errors, slips, missing)
      if (size(missing, 2) == 0) exit
      slips = matmul(slips, null_space(matmul(missing, transpose(missing))))
    end do
  end subroutine find_slips

  !> Lists the rows whose tangents the motions miss by more than the errors allow, as directions in the space of the motions.
  pure subroutine find_missing(velocities, normals, errors, slips, missing)
    real(rk), intent(in) :: velocities(:, :, :), normals(:, :), errors(:), slips(:, :)
    !> [-] unit vectors, shape (size(slips, 2), n)
    real(rk), allocatable, intent(out) :: missing(:, :)
    real(rk) :: row(size(slips, 2)), velocity(size(normals, 1), size(slips, 2))
    integer :: k

    allocate (missing(size(slips, 2), 0))
    do k = 1, size(errors)
      velocity = matmul(velocities(:, :, k), slips)
      row = matmul(normals(:, k), velocity)
      if (norm2(row) <= margin * errors(k) * norm2(velocity) + rounding_of_data) cycle
      missing = reshape([missing, row / norm2(row)], [size(row), size(missing, 2) + 1])
    end do
  end subroutine find_missing

  !> Measures by how much the slipping motions miss the tangents at the rows of each body.
  pure subroutine measure_misses(motions, rows, velocities, normals, slips, misses)
    type(rigid_motions_t), intent(in) :: motions
    type(contact_rows_t), intent(in) :: rows
    real(rk), intent(in) :: velocities(:, :, :), normals(:, :), slips(:, :)
    real(rk), intent(out) :: misses(:)
    real(rk) :: velocity(size(normals, 1), size(slips, 2)), wholes(size(misses))
    logical :: is_here(size(misses))
    integer :: k

    misses = 0
    wholes = 0
    do k = 1, rows%n_rows
      is_here = .false.
      is_here(motions%body_of_node(rows%nodes_of(k))) = .true.
      velocity = matmul(velocities(:, :, k), slips)
      where (is_here)
        misses = misses + sum(matmul(normals(:, k), velocity)**2)
        wholes = wholes + sum(velocity**2)
      end where
    end do
    where (wholes > 0) misses = sqrt(misses / wholes)
  end subroutine measure_misses

  !> Turns the normal of a row across the velocities of the slipping motions. Its coefficients keep their sizes.
  subroutine turn_row(velocity, rows, k)
    !> shape (n_dim, number of slipping motions)
    real(rk), intent(in) :: velocity(:, :)
    type(contact_rows_t), intent(inout) :: rows
    integer, intent(in) :: k
    real(rk), allocatable :: u(:, :), s(:), vt(:, :)
    real(rk) :: old(rows%n_dim), normal(rows%n_dim), length
    integer :: i

    call svd(velocity, u, s, vt)
    old = normal_of_row(rows, k)
    length = norm2(old)
    normal = old
    do i = 1, min(rows%n_dim - 1, count(s > max(rounding_of_data, parallel * s(1))))
      normal = normal - dot_product(u(:, i), normal) * u(:, i)
    end do
    if (norm2(normal) < 0.5_rk * length) return
    normal = normal * length / norm2(normal)
    do i = rows%offsets(k) + 1, rows%offsets(k + 1), rows%n_dim
      associate (own => rows%coefficients(i:i + rows%n_dim - 1))
        own = normal * dot_product(own, old) / length**2
      end associate
    end do
  end subroutine turn_row
end module sig_slipping_motions
