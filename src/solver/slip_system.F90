! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> The linear system of contacts with friction in given states, in the unknowns of sig_bound_form.
!>
!> The gap of a closed contact is held, and the slip of one that sticks. A contact that slips in the direction d has free tangential
!> unknowns under the force f lambda_n d, where lambda_n is what the held gap says, and across d under that of a spring (the
!> softness k of sig_friction_types): lambda_t = f lambda_n d + e (e . slip) / k. With A = T' K T and the residual r = A x - T' F,
!> in which row k of the contacts has -|B_k| lambda_k at its unknown, this is (r + E r + Z (x - x_0)) = 0 on the free unknowns. E
!> takes a multiple of the residual at gaps to slips, and is why the system is not symmetric; Z are the springs.
module sig_slip_system
  use sig_active_set, only: build_levels, find_residual
  use sig_bound_form, only: bound_form_t
  use sig_contact_system, only: contact_system_t
  use sig_friction_types, only: contact_open, contact_slips, contact_sticks, friction_workspace_t
  use sig_kinds, only: rk
  use sig_linear_solver, only: coupled_system_t, hold, linear_solver_t
  use sig_petsc_support, only: create_pattern => create_matrix, create_vector, precondition_failed
  use sig_reasons, only: reason_converged
  use petsc
  implicit none(type, external)
  private
  public :: slip_system_t, slip_data_t

  !> What is given at a time.
  type :: slip_data_t
    !> [force] loads, natural, shape (n_dofs)
    real(rk), allocatable :: forces(:)
    !> [length] u_D on prescribed dofs, else 0; natural, shape (n_dofs)
    real(rk), allocatable :: prescribed(:)
    !> [length] of the unknowns of all rows: where gaps close, and where there is no slip; shape (n_rows)
    real(rk), allocatable :: bounds(:)
    !> [-] coefficients of friction, 0 where there are no tangential rows or the contact is tied; shape (n_contacts)
    real(rk), allocatable :: friction(:)
  end type slip_data_t

  !> The system, and its solver. Set is_multigrid; call create, solve for any states, and destroy.
  type :: slip_system_t
    logical :: is_multigrid = .false.
    type(bound_form_t) :: form
    type(linear_solver_t) :: linear_solver
    type(coupled_system_t) :: coupled
    !> without multigrid: T' K T with springs and held unknowns, which is factored
    Mat :: matrix
    !> [force/length] springs of the preconditioner
    Mat :: held_springs
    Vec :: rhs
    Vec :: solution
    !> rows whose unknowns are held, shape (n_rows), and [force/length] 1 / k of contacts, in the preconditioner; not allocated
    !> before there is one
    logical, allocatable :: held_rows(:)
    real(rk), allocatable :: held_stiffness(:)
    !> contacts that change their unknowns, at least the closed ones, shape (n_rows)
    logical, allocatable :: changed_rows(:)
    !> size of a right-hand side
    real(rk) :: size_of_rhs = 0
    !> whether the last solve says that the factor is too old
    logical :: is_outdated = .false.
  contains
    procedure :: create
    procedure :: solve
    procedure :: rows_held
    procedure :: destroy
  end type slip_system_t

  !> usual number of iterations with an earlier factor; a factorization that takes less time than so many solves is made anew
  integer, parameter :: usual_iterations = 40
  !> [-] the preconditioner stays as it is if at most this share of the rows are held now and not before or the other way round, or
  !> have a spring that changed by more than a factor
  real(rk), parameter :: few = 0.003_rk, small_factor = 3.0_rk

contains

  !> Makes the unknowns, and the multigrid levels or T' K T. ierr is set where the rows of a contact cannot be unknowns; the plan of
  !> the solver refuses that. Collective.
  subroutine create(self, system, ierr)
    class(slip_system_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    PetscErrorCode, intent(out) :: ierr

    PetscCall(self%form%create(system, ierr))
    self%size_of_rhs = 0
    SIG_CHECK(all(self%form%norms > 0), PETSC_ERR_ARG_WRONG, 'each row of a contact has a free dof of its own')
    PetscCall(create_vector(system%comm, system%map%n_local_dofs, self%solution, ierr))
    PetscCall(create_vector(system%comm, system%map%n_local_dofs, self%rhs, ierr))
    PetscCall(create_vector(system%comm, system%map%n_local_dofs, self%coupled%is_free, ierr))
    PetscCall(create_couplings(self, system, self%coupled%coupling, ierr))
    PetscCall(create_couplings(self, system, self%coupled%springs, ierr))
    PetscCall(create_couplings(self, system, self%held_springs, ierr))
    self%coupled%has_springs = any(system%laws%tangents(2, :) > 0 .and. .not. system%laws%is_tied)
    self%linear_solver%is_multigrid = self%is_multigrid
    if (self%is_multigrid) then
      PetscCall(build_levels(self%form, self%linear_solver, system, ierr))
    else
      PetscCall(self%form%create_matrix(system, self%coupled%stiffness, ierr))
      PetscCall(MatDuplicate(self%coupled%stiffness, MAT_DO_NOT_COPY_VALUES, self%matrix, ierr))
    end if
  end subroutine create

  !> Makes a matrix of zeros between the unknowns of each contact. Collective.
  subroutine create_couplings(self, system, matrix, ierr)
    type(slip_system_t), intent(in) :: self
    type(contact_system_t), intent(in) :: system
    Mat, intent(out) :: matrix
    PetscErrorCode, intent(out) :: ierr
    integer, allocatable :: diagonal(:), off_diagonal(:)
    integer :: k

    associate (map => system%map)
      allocate (diagonal(map%n_local_dofs / map%n_dim), off_diagonal(map%n_local_dofs / map%n_dim), source=0)
      do k = 1, system%laws%n_contacts
        associate (dofs => self%form%bounded_dofs(system%laws%rows_of(k)))
          call map%count_blocks(dofs, spread(.true., 1, size(dofs)), diagonal, off_diagonal)
        end associate
      end do
      PetscCall(create_pattern(system%comm, map%n_local_dofs, map%n_dim, diagonal, off_diagonal, matrix, ierr))
    end associate
    PetscCall(fill(self, system, spread(spread(0.0_rk, 1, 3), 2, system%rows%n_rows), matrix, ierr))
  end subroutine create_couplings

  !> Sets the values of a matrix between the unknowns of each contact. Collective.
  subroutine fill(self, system, values, matrix, ierr)
    type(slip_system_t), intent(in) :: self
    type(contact_system_t), intent(in) :: system
    !> of each row, in the columns of the rows of its contact; shape (3, n_rows)
    real(rk), intent(in) :: values(:, :)
    Mat, intent(inout) :: matrix
    PetscErrorCode, intent(out) :: ierr
    integer :: i, k

    ierr = 0
    associate (map => system%map)
      do k = 1, system%laws%n_contacts
        associate (rows => system%laws%rows_of(k), dofs_0 => map%distributed_0(self%form%bounded_dofs(system%laws%rows_of(k))))
          do i = 1, size(rows)
            if (map%local_index(self%form%bounded_dofs(rows(i))) == 0) cycle
            PetscCall(MatSetValues(matrix, 1, dofs_0(i:i), size(rows), dofs_0, values(:size(rows), rows(i)), INSERT_VALUES, ierr))
          end do
        end associate
      end do
    end associate
    PetscCall(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY, ierr))
    PetscCall(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY, ierr))
  end subroutine fill

  !> Returns the rows whose unknowns are held: gaps of closed contacts, slips of those that stick. Shape (n_rows).
  pure function rows_held(self, system, states) result(is_held)
    class(slip_system_t), intent(in) :: self
    type(contact_system_t), intent(in) :: system
    !> shape (n_contacts)
    integer, intent(in) :: states(:)
    logical :: is_held(size(self%form%norms))
    integer :: k

    do k = 1, size(states)
      associate (tangents => system%laws%tangents(:system%laws%n_tangents(k), k))
        is_held(k) = states(k) /= contact_open
        is_held(tangents) = states(k) == contact_sticks
      end associate
    end do
  end function rows_held

  !> Solves for the states, directions and softness of the workspace, starting from a displacement. Collective.
  subroutine solve(self, system, data, workspace, reduction, displacement, ierr)
    class(slip_system_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    type(slip_data_t), intent(in) :: data
    type(friction_workspace_t), intent(in) :: workspace
    !> [-] by which what is left of the system at the start falls; 0: to the tightest tolerance
    real(rk), intent(in) :: reduction
    !> [length] natural, shape (n_dofs)
    real(rk), intent(inout) :: displacement(:)
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: held(system%map%n_dofs), unknowns(system%map%n_dofs), residual(system%map%n_dofs)
    real(rk) :: couplings(3, system%rows%n_rows), springs(3, system%rows%n_rows), stiffness(size(workspace%states))
    logical :: is_held(system%rows%n_rows), is_changed(system%rows%n_rows), is_kept
    integer, allocatable :: dofs(:)
    integer :: k

    ierr = 0
    is_held = self%rows_held(system, workspace%states)
    call list_couplings(self, system, data, workspace, couplings, springs, stiffness)
    is_kept = is_near(self, is_held, stiffness)
    is_changed = .true.
    if (is_kept) then
      is_changed = self%changed_rows
    else if (self%is_multigrid) then
      do k = 1, system%laws%n_contacts
        is_changed(system%laws%rows_of(k)) = workspace%states(k) /= contact_open
      end do
    end if
    dofs = [system%boundary%prescribed_dofs, pack(self%form%bounded_dofs, is_held)]
    unknowns = data%prescribed
    unknowns(self%form%bounded_dofs) = data%bounds
    held = 0
    held(dofs) = unknowns(dofs)
    PetscCall(set_couplings(self, system, couplings, springs, ierr))
    unknowns = held
    call self%form%to_displacement(system, unknowns, is_changed)
    PetscCall(find_residual(self%form, system, data%forces, unknowns, is_changed, residual, ierr))
    call add_slip_forces(self, system, data, couplings, springs, residual)
    residual(dofs) = 0
    PetscCall(system%put(-residual, self%rhs, ierr))
    PetscCall(prepare(self, system, is_kept, is_held, is_changed, stiffness, dofs, ierr))
    if (self%linear_solver%reason /= reason_converged) return
    unknowns = displacement
    call self%form%to_unknowns(system, unknowns, is_changed)
    unknowns(dofs) = 0
    PetscCall(system%put(unknowns, self%solution, ierr))
    PetscCall(self%linear_solver%solve_coupled(self%coupled, self%rhs, reduction, self%size_of_rhs, self%solution, ierr))
    self%is_outdated = .not. self%is_multigrid .and. self%linear_solver%n_iterations > usual_iterations
    if (self%linear_solver%reason /= reason_converged) return
    PetscCall(system%get(self%solution, unknowns, ierr))
    unknowns(dofs) = held(dofs)
    call self%form%to_displacement(system, unknowns, is_changed)
    displacement = unknowns
  end subroutine solve

  !> Computes the entries of E and Z, and 1 / k of each contact, 0 where there is no spring.
  pure subroutine list_couplings(self, system, data, workspace, couplings, springs, stiffness)
    type(slip_system_t), intent(in) :: self
    type(contact_system_t), intent(in) :: system
    type(slip_data_t), intent(in) :: data
    type(friction_workspace_t), intent(in) :: workspace
    !> as in fill
    real(rk), intent(out) :: couplings(:, :), springs(:, :)
    real(rk), intent(out) :: stiffness(:)
    real(rk) :: across(2)
    integer :: i, j, k

    couplings = 0
    springs = 0
    stiffness = 0
    do k = 1, system%laws%n_contacts
      if (workspace%states(k) /= contact_slips .or. .not. data%friction(k) > 0) cycle
      if (workspace%softness(k) < huge(1.0_rk)) stiffness(k) = 1 / workspace%softness(k)
      associate (rows => system%laws%tangents(:system%laws%n_tangents(k), k), d => workspace%directions(:, k), &
        norms => self%form%norms)
        across = [-d(2), d(1)]
        do i = 1, size(rows)
          couplings(1, rows(i)) = -data%friction(k) * d(i) * norms(rows(i)) / norms(k)
          do j = 1, size(rows)
            springs(1 + j, rows(i)) = stiffness(k) * norms(rows(i)) * norms(rows(j)) * across(i) * across(j)
          end do
        end do
      end associate
    end do
  end subroutine list_couplings

  !> Sets E and Z. Collective.
  subroutine set_couplings(self, system, couplings, springs, ierr)
    type(slip_system_t), intent(inout) :: self
    type(contact_system_t), intent(in) :: system
    real(rk), intent(in) :: couplings(:, :), springs(:, :)
    PetscErrorCode, intent(out) :: ierr

    self%coupled%has_coupling = any(abs(couplings) > 0)
    PetscCall(fill(self, system, couplings, self%coupled%coupling, ierr))
    PetscCall(fill(self, system, springs, self%coupled%springs, ierr))
  end subroutine set_couplings

  !> Adds E r - Z x_0 to a residual r.
  pure subroutine add_slip_forces(self, system, data, couplings, springs, residual)
    type(slip_system_t), intent(in) :: self
    type(contact_system_t), intent(in) :: system
    type(slip_data_t), intent(in) :: data
    real(rk), intent(in) :: couplings(:, :), springs(:, :)
    !> [force] natural, shape (n_dofs)
    real(rk), intent(inout) :: residual(:)
    integer :: i, k

    do k = 1, system%laws%n_contacts
      associate (rows => system%laws%tangents(:system%laws%n_tangents(k), k), dofs => self%form%bounded_dofs)
        do i = 1, size(rows)
          residual(dofs(rows(i))) = residual(dofs(rows(i))) + couplings(1, rows(i)) * residual(dofs(k)) - &
            dot_product(springs(2:1 + size(rows), rows(i)), data%bounds(rows))
        end do
      end associate
    end do
  end subroutine add_slip_forces

  !> Makes the preconditioner for the held unknowns: always with multigrid, whose levels cost little; where K is factored, if a
  !> factorization takes less time than the iterations that an earlier factor needs. Collective.
  subroutine prepare(self, system, is_kept, is_held, is_changed, stiffness, dofs, ierr)
    type(slip_system_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    !> whether it is good enough as it is
    logical, intent(in) :: is_kept
    logical, intent(in) :: is_held(:), is_changed(:)
    !> [force/length] 1 / k of contacts
    real(rk), intent(in) :: stiffness(:)
    !> held unknowns
    integer, intent(in) :: dofs(:)
    PetscErrorCode, intent(out) :: ierr
    logical :: is_free(system%map%n_dofs)
    integer :: n_solves

    ierr = 0
    if (self%is_multigrid .and. self%linear_solver%ksp == 0) return
    is_free = .true.
    is_free(dofs) = .false.
    PetscCall(system%put(merge(1.0_rk, 0.0_rk, is_free), self%coupled%is_free, ierr))
    if (is_kept .and. .not. self%is_outdated) return
    if (self%linear_solver%ksp /= 0 .and. .not. (self%is_multigrid .or. self%is_outdated)) then
      PetscCall(self%linear_solver%solves_per_factorization(n_solves, ierr))
      if (n_solves >= usual_iterations) return
    end if
    self%held_rows = is_held
    self%changed_rows = is_changed
    self%held_stiffness = stiffness
    if (self%coupled%has_springs) then
      PetscCall(MatCopy(self%coupled%springs, self%held_springs, SAME_NONZERO_PATTERN, ierr))
    end if
    if (self%is_multigrid) then
      PetscCall(hold_in_levels(self, system, is_changed, dofs, ierr))
    else
      PetscCall(factor_held(self, system, dofs, ierr))
    end if
  end subroutine prepare

  !> Whether the preconditioner is good enough for these held rows and springs.
  pure logical function is_near(self, is_held, stiffness)
    type(slip_system_t), intent(in) :: self
    logical, intent(in) :: is_held(:)
    real(rk), intent(in) :: stiffness(:)
    integer :: n

    is_near = allocated(self%held_rows)
    if (.not. is_near) return
    n = count(is_held .neqv. self%held_rows) + count(stiffness > small_factor * self%held_stiffness .or. &
      self%held_stiffness > small_factor * stiffness)
    is_near = n <= few * size(is_held) .and. .not. any(is_held .and. .not. self%changed_rows)
  end function is_near

  !> Collective.
  subroutine hold_in_levels(self, system, is_changed, dofs, ierr)
    type(slip_system_t), intent(inout) :: self
    type(contact_system_t), intent(inout) :: system
    logical, intent(in) :: is_changed(:)
    integer, intent(in) :: dofs(:)
    PetscErrorCode, intent(out) :: ierr
    Mat :: transformation, inverse

    PetscCall(self%form%create_transformation(system, is_changed, .false., transformation, ierr))
    PetscCall(self%form%create_transformation(system, is_changed, .true., inverse, ierr))
    if (self%coupled%has_springs) then
      PetscCall(self%linear_solver%hold_unknowns(system, transformation, inverse, dofs, ierr, self%held_springs))
    else
      PetscCall(self%linear_solver%hold_unknowns(system, transformation, inverse, dofs, ierr))
    end if
    PetscCall(MatDestroy(transformation, ierr))
    PetscCall(MatDestroy(inverse, ierr))
  end subroutine hold_in_levels

  !> Factors T' K T with springs and held unknowns. Collective.
  subroutine factor_held(self, system, dofs, ierr)
    type(slip_system_t), intent(inout) :: self
    type(contact_system_t), intent(in) :: system
    integer, intent(in) :: dofs(:)
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: nothing(system%map%n_dofs)

    nothing = 0
    PetscCall(MatCopy(self%coupled%stiffness, self%matrix, SAME_NONZERO_PATTERN, ierr))
    if (self%coupled%has_springs) then
      PetscCall(MatAXPY(self%matrix, 1.0_rk, self%held_springs, SUBSET_NONZERO_PATTERN, ierr))
    end if
    PetscCall(hold(system, dofs, nothing, self%matrix, self%rhs, ierr))
    if (self%linear_solver%ksp /= 0) then
      PetscCall(self%linear_solver%factor_again(ierr))
    else
      PetscCall(self%linear_solver%factor(self%matrix, 'active_set_', ierr))
    end if
    self%is_outdated = .false.
    if (self%linear_solver%reason /= reason_converged) then
      ! its reason stays
      PetscCall(self%linear_solver%destroy(ierr))
      deallocate (self%held_rows)
    end if
  end subroutine factor_held

  !> Frees all. Collective.
  subroutine destroy(self, ierr)
    class(slip_system_t), intent(inout) :: self
    PetscErrorCode, intent(out) :: ierr

    PetscCall(self%linear_solver%destroy(ierr))
    if (allocated(self%held_rows)) deallocate (self%held_rows)
    PetscCall(MatDestroy(self%coupled%stiffness, ierr))
    PetscCall(MatDestroy(self%coupled%coupling, ierr))
    PetscCall(MatDestroy(self%coupled%springs, ierr))
    PetscCall(MatDestroy(self%held_springs, ierr))
    PetscCall(MatDestroy(self%matrix, ierr))
    PetscCall(VecDestroy(self%coupled%is_free, ierr))
    PetscCall(VecDestroy(self%rhs, ierr))
    PetscCall(VecDestroy(self%solution, ierr))
  end subroutine destroy
end module sig_slip_system
