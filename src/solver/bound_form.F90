! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> The contact problem with simple bounds: in reflected unknowns, B_k u <= D_k becomes x_j <= bound for one unknown j per pair.
!>
!> For q_k = B_k' / |B_k| on the free dofs, the reflection I - 2 v v' with v along q_k - e_j swaps q_k and e_j. Pairs share
!> no node, so all reflections together are one orthogonal, symmetric matrix R: K becomes R K R and stays positive definite,
!> and lambda_k is the residual of row j over -|B_k|.
module sig_bound_form
  use sig_contact_system, only: contact_system_t
  use sig_kinds, only: rk
  use sig_petsc_support, only: create_matrix
  use petsc
  implicit none(type, external)
  private
  public :: bound_form_t

  type :: bound_form_t
    !> R, and R K R on all dofs
    Mat :: reflection
    Mat :: matrix
    !> [-] |B_k| on the free dofs, shape (n_rows)
    real(rk), allocatable :: norms(:)
    !> natural dof whose place the bounded unknown of row k takes, shape (n_rows)
    integer, allocatable :: bounded_dofs(:)
    !> [-] v of row k on operator%dofs(:, k), unit length or zero, 0 beyond its entries, shape (2 * n_dim, n_rows)
    real(rk), allocatable :: reflectors(:, :)
  contains
    procedure :: create
    procedure :: reflect
    procedure :: bounds
    procedure :: multipliers
    procedure :: destroy
  end type bound_form_t

contains

  !> Collective.
  subroutine create(self, system, ierr)
    class(bound_form_t), intent(out) :: self
    type(contact_system_t), intent(in) :: system
    PetscErrorCode, intent(out) :: ierr

    call set_reflectors(self, system)
    PetscCall(assemble_reflection(self, system, self%reflection, ierr))
    PetscCall(MatPtAP(system%stiffness, self%reflection, MAT_INITIAL_MATRIX, 2.0_rk, self%matrix, ierr))
    ! what a second product would use is as large as K
    PetscCall(MatProductClear(self%matrix, ierr))
    PetscCall(MatSetOption(self%matrix, MAT_SYMMETRIC, PETSC_TRUE, ierr))
  end subroutine create

  pure subroutine set_reflectors(self, system)
    class(bound_form_t), intent(inout) :: self
    type(contact_system_t), intent(in) :: system
    real(rk) :: direction(2 * system%map%n_dim), length
    integer :: k, n, place

    associate (operator => system%operator)
      allocate (self%norms(operator%n_rows), self%bounded_dofs(operator%n_rows))
      allocate (self%reflectors(2 * operator%n_dim, operator%n_rows))
      do k = 1, operator%n_rows
        n = operator%n_entries(k)
        direction = 0
        direction(:n) = merge(0.0_rk, operator%coefficients(:n, k), system%boundary%is_prescribed(operator%dofs(:n, k)))
        self%norms(k) = norm2(direction)
        direction = direction / self%norms(k)
        place = maxloc(abs(direction), dim=1)
        self%bounded_dofs(k) = operator%dofs(place, k)
        direction(place) = direction(place) - 1
        length = norm2(direction)
        self%reflectors(:, k) = 0
        if (length > 0) self%reflectors(:, k) = direction / length
      end do
    end associate
  end subroutine set_reflectors

  !> R as a matrix: the identity and one full block per contact row. Both nodes of a pair have one owner.
  subroutine assemble_reflection(self, system, reflection, ierr)
    class(bound_form_t), intent(in) :: self
    type(contact_system_t), intent(in) :: system
    Mat, intent(out) :: reflection
    PetscErrorCode, intent(out) :: ierr
    integer :: i, k, n, n_blocks
    integer, allocatable :: dofs_0(:), two(:)
    real(rk), allocatable :: block(:, :)

    n_blocks = system%map%n_local_dofs / system%map%n_dim
    allocate (two(n_blocks), source=2)
    PetscCall(create_matrix(system%comm, system%map%n_local_dofs, system%map%n_dim, two, two - 2, reflection, ierr))
    do i = system%map%first_dof_0, system%map%first_dof_0 + system%map%n_local_dofs - 1
      PetscCall(MatSetValue(reflection, i, i, 1.0_rk, ADD_VALUES, ierr))
    end do
    do k = 1, system%operator%n_rows
      n = system%operator%n_entries(k)
      dofs_0 = system%map%distributed_0(system%operator%dofs(:n, k))
      if (dofs_0(1) < system%map%first_dof_0 .or. dofs_0(1) >= system%map%first_dof_0 + system%map%n_local_dofs) cycle
      block = -2 * spread(self%reflectors(:n, k), 2, n) * spread(self%reflectors(:n, k), 1, n)
      PetscCall(MatSetValues(reflection, n, dofs_0, n, dofs_0, block, ADD_VALUES, ierr))
    end do
    PetscCall(MatAssemblyBegin(reflection, MAT_FINAL_ASSEMBLY, ierr))
    PetscCall(MatAssemblyEnd(reflection, MAT_FINAL_ASSEMBLY, ierr))
  end subroutine assemble_reflection

  !> R x, in place: from displacements to reflected unknowns and back. Local.
  pure subroutine reflect(self, system, values)
    class(bound_form_t), intent(in) :: self
    type(contact_system_t), intent(in) :: system
    !> natural, shape (n_dofs)
    real(rk), intent(inout) :: values(:)
    integer :: k

    do k = 1, system%operator%n_rows
      associate (n => system%operator%n_entries(k))
        associate (dofs => system%operator%dofs(:n, k), v => self%reflectors(:n, k))
          values(dofs) = values(dofs) - 2 * v * dot_product(v, values(dofs))
        end associate
      end associate
    end do
  end subroutine reflect

  !> Upper bounds of the bounded unknowns: (D - B u_D) / |B_k|. Local.
  pure function bounds(self, system, theta)
    class(bound_form_t), intent(in) :: self
    type(contact_system_t), intent(in) :: system
    real(rk), intent(in) :: theta(:)
    !> [length] shape (n_rows)
    real(rk) :: bounds(system%operator%n_rows)

    bounds = (system%gap(theta) - system%operator%apply(system%prescribed_displacement(theta))) / self%norms
  end function bounds

  !> lambda_k from the residual R (K R x - F). Local.
  pure function multipliers(self, residual)
    class(bound_form_t), intent(in) :: self
    !> [force] natural, shape (n_dofs)
    real(rk), intent(in) :: residual(:)
    !> [force] shape (n_rows)
    real(rk) :: multipliers(size(self%norms))

    multipliers = -residual(self%bounded_dofs) / self%norms
  end function multipliers

  subroutine destroy(self, ierr)
    class(bound_form_t), intent(inout) :: self
    PetscErrorCode, intent(out) :: ierr

    PetscCall(MatDestroy(self%reflection, ierr))
    PetscCall(MatDestroy(self%matrix, ierr))
  end subroutine destroy
end module sig_bound_form
