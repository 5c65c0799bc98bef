! SPDX-License-Identifier: BSD-3-Clause
!> Strains of cells or at nodes as a linear function of the displacement. The map is made once from a mesh; its use needs no mesh.
module sig_strain_map
  use sig_elasticity, only: n_stresses
  use sig_kinds, only: rk
  use sig_mechanical_models, only: mechanical_model_t
  implicit none(type, external)
  private
  public :: strain_map_t

  !> A row belongs to a cell or a node. Its displacement gradient is the sum of u g' over its entries starts(row) + 1 ... starts(row
  !> + 1), where u is the displacement of the entry's node.
  type :: strain_map_t
    !> shape (n_rows + 1)
    integer, allocatable :: starts(:)
    !> natural node of each entry
    integer, allocatable :: nodes(:)
    !> [1/length] g of each entry, shape (3, n_entries); in axisymmetry the third one is N / r
    real(rk), allocatable :: gradients(:, :)
    !> material of each row, 1-based, 0 = none; shape (n_rows)
    integer, allocatable :: materials(:)
    !> imposed strains: imposed(:, i), times the value of term imposed_terms(i), adds to row imposed_rows(i); [-] shears as angles,
    !> shape (n_stresses, n)
    real(rk), allocatable :: imposed(:, :)
    integer, allocatable :: imposed_rows(:)
    integer, allocatable :: imposed_terms(:)
    !> how values at the integration points of cells that flow (plasticity, creep) are spread to the rows: row i gets the values of
    !> points(point_starts(i) + 1:point_starts(i + 1)) times point_weights; points are 1-based, shapes (n_rows + 1) and (n)
    integer, allocatable :: point_starts(:)
    integer, allocatable :: points(:)
    real(rk), allocatable :: point_weights(:)
  contains
    procedure :: n_rows
    procedure :: spread_points
    procedure :: fill_strains
    procedure :: fill_imposed
    procedure :: fill_stresses
  end type strain_map_t

contains

  !> Returns the number of rows (cells or nodes); 0 if the map was not made.
  pure integer function n_rows(self)
    class(strain_map_t), intent(in) :: self

    n_rows = 0
    if (allocated(self%materials)) n_rows = size(self%materials)
  end function n_rows

  !> Spreads values at the integration points of cells that flow to the rows; rows without such points get zeros.
  pure subroutine spread_points(self, values, rows)
    class(strain_map_t), intent(in) :: self
    !> shape (n_values, n_points)
    real(rk), intent(in) :: values(:, :)
    !> shape (n_values, n_rows)
    real(rk), intent(out) :: rows(:, :)
    integer :: i, row

    rows = 0
    do row = 1, self%n_rows()
      do i = self%point_starts(row) + 1, self%point_starts(row + 1)
        rows(:, row) = rows(:, row) + self%point_weights(i) * values(:, self%points(i))
      end do
    end do
  end subroutine spread_points

  !> Computes the total strains (elastic plus imposed) of each row (a cell or a node) from a displacement. Components that the model
  !> does not have are zero; in plane stress this holds for eps_zz, too.
  pure subroutine fill_strains(self, model, displacement, strains)
    class(strain_map_t), intent(in) :: self
    type(mechanical_model_t), intent(in) :: model
    !> [length] of all nodes, natural, shape (n_dim, n_nodes)
    real(rk), intent(in) :: displacement(:, :)
    !> [-] xx, yy, zz, xy, yz, xz, shears as angles, shape (n_stresses, n_rows)
    real(rk), intent(out) :: strains(:, :)
    real(rk) :: slopes(3, 3)
    integer :: i, k, row

    do row = 1, self%n_rows()
      slopes = 0
      do i = self%starts(row) + 1, self%starts(row + 1)
        do k = 1, 3
          slopes(:model%n_dim, k) = slopes(:model%n_dim, k) + displacement(:, self%nodes(i)) * self%gradients(k, i)
        end do
      end do
      strains(:, row) = [slopes(1, 1), slopes(2, 2), slopes(3, 3), slopes(1, 2) + slopes(2, 1), slopes(2, 3) + slopes(3, 2), &
        slopes(1, 3) + slopes(3, 1)]
      if (model%n_dim == 3) cycle
      strains(3, row) = merge(slopes(1, 3), 0.0_rk, model%is_round)
      strains(5:, row) = 0
    end do
  end subroutine fill_strains

  !> Computes the imposed strains of each row from the values of their terms. Rows without imposed strains get zeros.
  pure subroutine fill_imposed(self, theta, strains)
    class(strain_map_t), intent(in) :: self
    !> [-] values of the terms; imposed_terms has their indices, 1-based
    real(rk), intent(in) :: theta(:)
    !> [-] shears as angles, shape (n_stresses, n_rows)
    real(rk), intent(out) :: strains(:, :)
    integer :: i

    strains = 0
    do i = 1, size(self%imposed_rows)
      associate (row => self%imposed_rows(i))
        strains(:, row) = strains(:, row) + theta(self%imposed_terms(i)) * self%imposed(:, i)
      end associate
    end do
  end subroutine fill_imposed

  !> Computes the stresses of each row from its elastic strains (total minus imposed); zero in rows without a material.
  pure subroutine fill_stresses(self, laws, strains, stresses)
    class(strain_map_t), intent(in) :: self
    !> [force/length**2] stress_matrix of each material, shape (n_stresses, n_stresses, n_materials)
    real(rk), intent(in) :: laws(:, :, :)
    !> [-] elastic strains, shears as angles, shape (n_stresses, n_rows)
    real(rk), intent(in) :: strains(:, :)
    !> [force/length**2] same shape
    real(rk), intent(out) :: stresses(:, :)
    integer :: row

    stresses = 0
    do row = 1, self%n_rows()
      if (self%materials(row) > 0) stresses(:, row) = matmul(laws(:, :, self%materials(row)), strains(:n_stresses, row))
    end do
  end subroutine fill_stresses
end module sig_strain_map
