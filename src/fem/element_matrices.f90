! SPDX-License-Identifier: BSD-3-Clause
!> Computes strain matrix and stiffness of one element from the coordinates of its nodes and its tabulated shape functions.
module sig_element_matrices
  use sig_kinds, only: rk
  use sig_linear_algebra, only: add_product
  use sig_mechanical_models, only: circumference, mechanical_model_t
  use sig_shape_functions, only: shape_table_t
  implicit none(type, external)
  private
  public :: element_stiffness, strains_at_point, physical_gradients

  !> each strain xx, yy, zz, xy, yz, xz is the sum of two derivatives d u_component / d direction; 0 = no second derivative
  integer, parameter :: components(2, 6) = reshape([1, 0, 2, 0, 3, 0, 1, 2, 2, 3, 1, 3], [2, 6])
  integer, parameter :: directions(2, 6) = reshape([1, 0, 2, 0, 3, 0, 2, 1, 3, 2, 3, 1], [2, 6])

contains

  !> Returns the stiffness of one element, the integral of strain' * hooke * strain: per unit thickness in the plane, over the full
  !> turn in axisymmetry.
  !>
  !> The strain matrices of all integration points stand in one matrix, so that one product is enough.
  function element_stiffness(model, table, coordinates, hooke) result(stiffness)
    type(mechanical_model_t), intent(in) :: model
    !> shape functions of the element type
    type(shape_table_t), intent(in) :: table
    !> [length] shape (n_dim, n_nodes)
    real(rk), intent(in) :: coordinates(:, :)
    !> [force/length**2] shape (n_strains, n_strains)
    real(rk), intent(in) :: hooke(:, :)
    !> [force/length, force/length**2 in the plane] symmetric, dofs node by node
    real(rk) :: stiffness(size(coordinates), size(coordinates))
    real(rk) :: strain(size(hooke, 1), size(coordinates)), volume
    real(rk) :: strains(size(coordinates), size(hooke, 1) * table%n_points)
    real(rk) :: stresses(size(hooke, 1) * table%n_points, size(coordinates))
    integer :: first, i_point, last

    do i_point = 1, table%n_points
      call strains_at_point(model, table, i_point, coordinates, strain, volume)
      first = (i_point - 1) * size(hooke, 1) + 1
      last = i_point * size(hooke, 1)
      strains(:, first:last) = transpose(strain)
      stresses(first:last, :) = volume * matmul(hooke, strain)
    end do
    stiffness = 0
    call add_product(1.0_rk, strains, stresses, stiffness)
  end function element_stiffness

  !> Computes the strain matrix at an integration point and the volume of this point. Strains are the matrix times the nodal
  !> displacements, node by node; shears are angles.
  pure subroutine strains_at_point(model, table, i_point, coordinates, strain, volume)
    type(mechanical_model_t), intent(in) :: model
    !> shape functions of the element type
    type(shape_table_t), intent(in) :: table
    !> number of the integration point, 1-based
    integer, intent(in) :: i_point
    !> [length] shape (n_dim, n_nodes)
    real(rk), intent(in) :: coordinates(:, :)
    !> [1/length] shape (n_strains, n_dim * n_nodes)
    real(rk), intent(out) :: strain(:, :)
    !> [length**3, length**2 in the plane] weight times Jacobian determinant times circumference
    real(rk), intent(out) :: volume
    real(rk) :: gradients(3, size(coordinates, 2)), place(size(coordinates, 1))

    call physical_gradients(table, i_point, coordinates, gradients(:size(place), :), volume)
    place = matmul(coordinates, table%values(:, i_point))
    volume = volume * circumference(model, place)
    ! eps_hoop = u_r / r: points lie inside the elements, so r > 0 also beside the axis
    if (model%is_round) gradients(3, :) = table%values(:, i_point) / place(1)
    strain = strain_matrix(model, gradients)
  end subroutine strains_at_point

  !> Computes the gradients of the shape functions in space at an integration point, and the volume of this point.
  pure subroutine physical_gradients(table, i_point, coordinates, gradients, volume)
    !> shape functions of the element type
    type(shape_table_t), intent(in) :: table
    !> number of the integration point, 1-based
    integer, intent(in) :: i_point
    !> [length] shape (n_dim, n_nodes)
    real(rk), intent(in) :: coordinates(:, :)
    !> [1/length] shape (n_dim, n_nodes)
    real(rk), intent(out) :: gradients(:, :)
    !> [length**n_dim] weight times Jacobian determinant, without the circumference of axisymmetry
    real(rk), intent(out) :: volume
    real(rk) :: jacobian(size(coordinates, 1), size(coordinates, 1)), determinant

    jacobian = matmul(coordinates, transpose(table%gradients(:, :, i_point)))
    call invert_transposed(jacobian, determinant)
    gradients = matmul(jacobian, table%gradients(:, :, i_point))
    volume = table%weights(i_point) * determinant
  end subroutine physical_gradients

  !> Replaces a 2 x 2 or 3 x 3 matrix by the transpose of its inverse (cofactors / determinant). Requires: it is not singular.
  pure subroutine invert_transposed(matrix, determinant)
    real(rk), intent(inout) :: matrix(:, :)
    !> of the matrix before
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

  !> Returns the matrix that gives strains, shears as angles, from nodal displacements. Its rows are in the order of model%strains.
  pure function strain_matrix(model, gradients) result(strain)
    type(mechanical_model_t), intent(in) :: model
    !> [1/length] shape (at least n_dim, n_nodes); in axisymmetry the third row is N / r
    real(rk), intent(in) :: gradients(:, :)
    !> [1/length] shape (n_strains, n_dim * n_nodes)
    real(rk) :: strain(model%n_strains, model%n_dim * size(gradients, 2))
    integer :: component, i_strain, i_term, tensor

    strain = 0
    do i_strain = 1, model%n_strains
      tensor = model%strains(i_strain)
      do i_term = 1, 2
        component = components(i_term, tensor)
        if (component == 0) cycle
        ! a plane model has a third normal strain only around the axis, and that comes from u_r
        if (component > model%n_dim) component = 1
        strain(i_strain, component::model%n_dim) = gradients(directions(i_term, tensor), :)
      end do
    end do
  end function strain_matrix
end module sig_element_matrices
