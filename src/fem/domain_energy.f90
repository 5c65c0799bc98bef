! SPDX-License-Identifier: BSD-3-Clause
!> Computes the strain energy of some cells for many displacement fields. The stiffness matrices of the cells are computed once.
module sig_domain_energy
  use sig_cell_stiffness, only: cell_dofs, cell_stiffness
  use sig_elastic_body, only: elastic_body_t
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  implicit none(type, external)
  private
  public :: domain_energy_t

  !> The stiffness matrices of some cells.
  type :: domain_energy_t
    private
    !> where each cell's dofs and matrix begin, less 1, shape (n_cells + 1)
    integer, allocatable :: dof_offsets(:)
    integer, allocatable :: matrix_offsets(:)
    !> natural dofs of the cells, one cell after the other
    integer, allocatable :: dofs(:)
    !> [force/length, force/length**2 in the plane] the cells' matrices column by column, one cell after the other
    real(rk), allocatable :: matrices(:)
  contains
    procedure :: create
    procedure :: strain_energy
  end type domain_energy_t

contains

  !> Computes and keeps the stiffness matrix of each of the cells: one full matrix per cell. Local.
  subroutine create(self, mesh, body, cells)
    class(domain_energy_t), intent(out) :: self
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    !> 1-based
    integer, intent(in) :: cells(:)
    integer :: i

    allocate (self%dof_offsets(size(cells) + 1), self%matrix_offsets(size(cells) + 1), source=0)
    do i = 1, size(cells)
      associate (n => size(cell_dofs(mesh, cells(i))))
        self%dof_offsets(i + 1) = self%dof_offsets(i) + n
        self%matrix_offsets(i + 1) = self%matrix_offsets(i) + n**2
      end associate
    end do
    allocate (self%dofs(self%dof_offsets(size(cells) + 1)), self%matrices(self%matrix_offsets(size(cells) + 1)))
    do i = 1, size(cells)
      self%dofs(self%dof_offsets(i) + 1:self%dof_offsets(i + 1)) = cell_dofs(mesh, cells(i))
      associate (matrix => cell_stiffness(mesh, body, cells(i)))
        self%matrices(self%matrix_offsets(i) + 1:self%matrix_offsets(i + 1)) = reshape(matrix, [size(matrix)])
      end associate
    end do
  end subroutine create

  !> Returns 1/2 u' K u [force*length, force in the plane] over the cells: the energy of (19) without loads and imposed strains.
  pure real(rk) function strain_energy(self, displacement) result(energy)
    class(domain_energy_t), intent(in) :: self
    !> [length] shape (n_dofs)
    real(rk), intent(in) :: displacement(:)
    integer :: i

    energy = 0
    do i = 1, size(self%dof_offsets) - 1
      associate (dofs => self%dofs(self%dof_offsets(i) + 1:self%dof_offsets(i + 1)))
        energy = energy + quadratic_form(size(dofs), self%matrices(self%matrix_offsets(i) + 1), displacement(dofs)) / 2
      end associate
    end do
  end function strain_energy

  !> Returns x' A x.
  pure real(rk) function quadratic_form(n, matrix, x) result(form)
    integer, intent(in) :: n
    real(rk), intent(in) :: matrix(n, n)
    real(rk), intent(in) :: x(n)
    integer :: j

    form = 0
    do j = 1, n
      form = form + x(j) * dot_product(matrix(:, j), x)
    end do
  end function quadratic_form
end module sig_domain_energy
