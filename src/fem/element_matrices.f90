! SPDX-License-Identifier: BSD-3-Clause
!> Element kernels: strain matrix and stiffness of one element from its nodes and its tabulated shape functions.
module sig_element_matrices
  use sig_kinds, only: rk
  use sig_shape_functions, only: shape_table_t
  implicit none(type, external)
  private
  public :: element_stiffness, strain_matrix, physical_gradients

contains

  !> Integral of strain' * hooke * strain over the element (per unit thickness in the plane).
  pure function element_stiffness(table, coordinates, hooke) result(stiffness)
    type(shape_table_t), intent(in) :: table
    !> [length] shape (n_dim, n_nodes)
    real(rk), intent(in) :: coordinates(:, :)
    !> [force/length**2] shape (n_strains, n_strains)
    real(rk), intent(in) :: hooke(:, :)
    !> [force/length**2 in the plane] symmetric, dofs node by node
    real(rk) :: stiffness(size(coordinates), size(coordinates))
    real(rk) :: gradients(size(coordinates, 1), size(coordinates, 2)), volume
    real(rk) :: strain(size(hooke, 1), size(coordinates))
    integer :: i_point

    stiffness = 0
    do i_point = 1, table%n_points
      call physical_gradients(table, i_point, coordinates, gradients, volume)
      strain = strain_matrix(gradients, size(hooke, 1))
      stiffness = stiffness + volume * matmul(transpose(strain), matmul(hooke, strain))
    end do
  end function element_stiffness

  !> Gradients of the shape functions in space and the volume that an integration point stands for.
  pure subroutine physical_gradients(table, i_point, coordinates, gradients, volume)
    type(shape_table_t), intent(in) :: table
    integer, intent(in) :: i_point
    real(rk), intent(in) :: coordinates(:, :)
    !> [1/length] shape (n_dim, n_nodes)
    real(rk), intent(out) :: gradients(:, :)
    !> [length**n_dim] weight times Jacobian determinant
    real(rk), intent(out) :: volume
    real(rk) :: jacobian(size(coordinates, 1), size(coordinates, 1)), determinant

    jacobian = matmul(coordinates, transpose(table%gradients(:, :, i_point)))
    call invert_transposed(jacobian, determinant)
    gradients = matmul(jacobian, table%gradients(:, :, i_point))
    volume = table%weights(i_point) * determinant
  end subroutine physical_gradients

  !> Replaces a 2 x 2 or 3 x 3 matrix by the transpose of its inverse (cofactors / determinant).
  pure subroutine invert_transposed(matrix, determinant)
    real(rk), intent(inout) :: matrix(:, :)
    real(rk), intent(out) :: determinant
    real(rk) :: cofactors(size(matrix, 1), size(matrix, 1))
    integer :: i, j, i1, i2, j1, j2

    if (size(matrix, 1) == 2) then
      cofactors = reshape([matrix(2, 2), -matrix(1, 2), -matrix(2, 1), matrix(1, 1)], [2, 2])
    else
      do j = 1, 3
        do i = 1, 3
          i1 = modulo(i, 3) + 1
          i2 = modulo(i + 1, 3) + 1
          j1 = modulo(j, 3) + 1
          j2 = modulo(j + 1, 3) + 1
          cofactors(i, j) = matrix(i1, j1) * matrix(i2, j2) - matrix(i1, j2) * matrix(i2, j1)
        end do
      end do
    end if
    determinant = dot_product(matrix(1, :), cofactors(1, :))
    matrix = cofactors / determinant
  end subroutine invert_transposed

  !> Strains (xx, yy, 2 xy) = strain_matrix * nodal displacements.
  pure function strain_matrix(gradients, n_strains) result(strain)
    !> [1/length] shape (n_dim, n_nodes)
    real(rk), intent(in) :: gradients(:, :)
    integer, intent(in) :: n_strains
    !> [1/length] shape (n_strains, n_dim * n_nodes)
    real(rk) :: strain(n_strains, size(gradients))
    integer :: i_node, first

    strain = 0
    do i_node = 1, size(gradients, 2)
      first = 2 * (i_node - 1)
      strain(1, first + 1) = gradients(1, i_node)
      strain(2, first + 2) = gradients(2, i_node)
      strain(3, first + 1) = gradients(2, i_node)
      strain(3, first + 2) = gradients(1, i_node)
    end do
  end function strain_matrix
end module sig_element_matrices
