! SPDX-License-Identifier: BSD-3-Clause
!> The snapshots on which a model is trained: all or some snapshots of one or several sets. Their arrays are not copied.
module sig_training_set
  use sig_hdf5_writer, only: column_t
  use sig_kinds, only: rk
  use sig_snapshot_store, only: snapshot_set_t
  use sig_text, only: string_t
  implicit none(type, external)
  private
  public :: training_set_t, take_snapshots

  !> Has pointers into the sets from which it was taken: these must outlive it and must not change.
  type :: training_set_t
    type(string_t), allocatable :: parameter_names(:)
    !> shape (n_parameters, m), m = number of snapshots
    real(rk), allocatable :: parameters(:, :)
    !> [length] this rank's dofs of each snapshot, from first_dof on; shape (m)
    type(column_t), allocatable :: displacement(:)
    integer :: first_dof = 1
    !> number of dofs of this rank, and of all ranks
    integer :: n_own = 0
    integer :: n_dofs = 0
    !> [force] contact forces, one column per snapshot; shape (m)
    type(column_t), allocatable :: multipliers(:)
    !> [length] response to each term without contact, on every rank; shape (n_dofs, n_terms)
    real(rk), pointer, contiguous :: free_response(:, :) => null()
    !> [length] by how much inelastic strains open each contact row; not allocated where they are not known, or where no material
    !> flows. Shape (n_rows, m)
    real(rk), allocatable :: openings(:, :)
  contains
    procedure :: n_snapshots
    procedure :: forces
    procedure :: select => select_snapshots
    procedure :: append
  end type training_set_t

contains

  !> Returns a training set of the snapshots with these numbers, in this order; of their displacements, forces and the free response
  !> it has pointers into `set`. Whether they are solved is not checked.
  function take_snapshots(set, numbers) result(taken)
    !> must be a target that outlives the result
    type(snapshot_set_t), intent(in), target :: set
    !> 1-based
    integer, intent(in) :: numbers(:)
    type(training_set_t) :: taken
    integer :: i

    if (allocated(set%parameter_names)) taken%parameter_names = set%parameter_names
    taken%parameters = set%parameters(:, numbers)
    taken%first_dof = set%first_dof
    taken%n_own = size(set%displacement, 1)
    taken%n_dofs = set%n_dofs
    if (allocated(set%free_response)) taken%free_response => set%free_response
    allocate (taken%displacement(size(numbers)), taken%multipliers(size(numbers)))
    do i = 1, size(numbers)
      taken%displacement(i)%values => set%displacement(:, numbers(i))
      taken%multipliers(i)%values => set%multipliers(:, numbers(i))
    end do
  end function take_snapshots

  !> Returns the number of snapshots, m.
  pure integer function n_snapshots(self)
    class(training_set_t), intent(in) :: self

    n_snapshots = size(self%displacement)
  end function n_snapshots

  !> [force] Returns a copy of the contact forces, shape (n_multipliers, m). Requires: at least one snapshot.
  pure function forces(self) result(matrix)
    class(training_set_t), intent(in) :: self
    real(rk), allocatable :: matrix(:, :)
    integer :: i

    allocate (matrix(size(self%multipliers(1)%values), size(self%multipliers)))
    do i = 1, size(matrix, 2)
      matrix(:, i) = self%multipliers(i)%values
    end do
  end function forces

  !> Returns a training set of the snapshots with these numbers in this one. It has pointers into the same sets.
  function select_snapshots(self, numbers) result(some)
    class(training_set_t), intent(in) :: self
    !> 1-based
    integer, intent(in) :: numbers(:)
    type(training_set_t) :: some

    if (allocated(self%parameter_names)) some%parameter_names = self%parameter_names
    some%parameters = self%parameters(:, numbers)
    some%displacement = self%displacement(numbers)
    some%first_dof = self%first_dof
    some%n_own = self%n_own
    some%n_dofs = self%n_dofs
    some%multipliers = self%multipliers(numbers)
    some%free_response => self%free_response
  end function select_snapshots

  !> Appends further snapshots of the same problem and with the same distribution of dofs, which is not checked. Of their
  !> displacements and forces only the pointers are copied: the sets into which they point must outlive `self`, too. The free
  !> response stays that of `self`.
  subroutine append(self, further)
    class(training_set_t), intent(inout) :: self
    type(training_set_t), intent(in) :: further

    self%parameters = reshape([self%parameters, further%parameters], &
      [size(self%parameters, 1), size(self%parameters, 2) + size(further%parameters, 2)])
    self%displacement = [self%displacement, further%displacement]
    self%multipliers = [self%multipliers, further%multipliers]
  end subroutine append
end module sig_training_set
