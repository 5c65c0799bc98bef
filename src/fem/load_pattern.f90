! SPDX-License-Identifier: BSD-3-Clause
!> Nodal forces as a sum of terms, F(mu) = sum over t of theta_t(mu) F_t. Only the entries of F_t that are not zero are kept.
module sig_load_pattern
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: load_pattern_t

  !> Entry i adds values(i) * theta(terms(i)) to the force on dofs(i). The arrays are not allocated if there are no entries.
  type :: load_pattern_t
    !> natural
    integer, allocatable :: dofs(:)
    !> 1-based
    integer, allocatable :: terms(:)
    !> [force]
    real(rk), allocatable :: values(:)
  contains
    procedure :: n_entries
    procedure :: n_terms
    procedure :: add_pattern
    procedure :: add_forces
    procedure :: add_units
    procedure :: forces
    procedure :: part_sizes
    procedure :: loaded_dofs
  end type load_pattern_t

  !> [-] a force of at most this share of the largest of part_sizes is rounding. Such forces remain where a temperature equals its
  !> reference, and inside of a body with a uniform temperature.
  real(rk), parameter :: rounding = 16 * epsilon(1.0_rk)

contains

  !> Returns the number of entries.
  pure integer function n_entries(self)
    class(load_pattern_t), intent(in) :: self

    n_entries = 0
    if (allocated(self%dofs)) n_entries = size(self%dofs)
  end function n_entries

  !> Returns the number of different terms that have entries.
  pure integer function n_terms(self)
    class(load_pattern_t), intent(in) :: self
    logical, allocatable :: has_entries(:)

    n_terms = 0
    if (self%n_entries() == 0) return
    allocate (has_entries(maxval(self%terms)), source=.false.)
    has_entries(self%terms) = .true.
    n_terms = count(has_entries)
  end function n_terms

  !> Adds the entries of another pattern behind those that are there.
  pure subroutine add_pattern(self, other)
    class(load_pattern_t), intent(inout) :: self
    type(load_pattern_t), intent(in) :: other

    if (other%n_entries() > 0) call append(self, other%dofs, other%terms, other%values)
  end subroutine add_pattern

  !> Adds the forces on all dofs to one term; zeros are left out.
  pure subroutine add_forces(self, i_term, forces)
    class(load_pattern_t), intent(inout) :: self
    !> index of the term, 1-based
    integer, intent(in) :: i_term
    !> [force] shape (n_dofs)
    real(rk), intent(in) :: forces(:)
    integer :: i

    associate (dofs => pack([(i, i=1, size(forces))], abs(forces) > 0))
      call append(self, dofs, spread(i_term, 1, size(dofs)), forces(dofs))
    end associate
  end subroutine add_forces

  !> Adds entries of 1: the value of term terms(i) then adds to the force [force] on dofs(i).
  pure subroutine add_units(self, terms, dofs)
    class(load_pattern_t), intent(inout) :: self
    !> 1-based, shape (size(dofs))
    integer, intent(in) :: terms(:)
    !> natural
    integer, intent(in) :: dofs(:)

    call append(self, dofs, terms, spread(1.0_rk, 1, size(dofs)))
  end subroutine add_units

  !> Appends entries, one for each element of the three arrays.
  pure subroutine append(self, dofs, terms, values)
    class(load_pattern_t), intent(inout) :: self
    integer, intent(in) :: dofs(:)
    integer, intent(in) :: terms(:)
    real(rk), intent(in) :: values(:)

    if (.not. allocated(self%dofs)) allocate (self%dofs(0), self%terms(0), self%values(0))
    self%dofs = [self%dofs, dofs]
    self%terms = [self%terms, terms]
    self%values = [self%values, values]
  end subroutine append

  !> Returns the nodal forces F(mu). A force of at most 16 times the machine epsilon times the largest of part_sizes is rounding,
  !> and is set to zero.
  pure function forces(self, theta, n_dofs)
    class(load_pattern_t), intent(in) :: self
    !> [-] values of terms 1, 2, ..., at least up to the largest index in self%terms
    real(rk), intent(in) :: theta(:)
    !> number of all dofs
    integer, intent(in) :: n_dofs
    !> [force] natural, shape (n_dofs)
    real(rk) :: forces(n_dofs)
    integer :: i

    forces = 0
    do i = 1, self%n_entries()
      forces(self%dofs(i)) = forces(self%dofs(i)) + self%values(i) * theta(self%terms(i))
    end do
    where (abs(forces) <= rounding * maxval(self%part_sizes(theta, n_dofs))) forces = 0
  end function forces

  !> Returns for each dof the sum over its entries of |value * theta|: what `forces` would be if no parts canceled.
  pure function part_sizes(self, theta, n_dofs) result(sizes)
    class(load_pattern_t), intent(in) :: self
    !> [-] values of terms 1, 2, ..., at least up to the largest index in self%terms
    real(rk), intent(in) :: theta(:)
    !> number of all dofs
    integer, intent(in) :: n_dofs
    !> [force] natural, shape (n_dofs)
    real(rk) :: sizes(n_dofs)
    integer :: i

    sizes = 0
    do i = 1, self%n_entries()
      sizes(self%dofs(i)) = sizes(self%dofs(i)) + abs(self%values(i) * theta(self%terms(i)))
    end do
  end function part_sizes

  !> Returns the natural dofs that have an entry, ascending.
  pure function loaded_dofs(self, n_dofs) result(dofs)
    class(load_pattern_t), intent(in) :: self
    !> number of all dofs
    integer, intent(in) :: n_dofs
    integer, allocatable :: dofs(:)
    logical :: is_loaded(n_dofs)
    integer :: i

    is_loaded = .false.
    if (self%n_entries() > 0) is_loaded(self%dofs) = .true.
    dofs = pack([(i, i=1, n_dofs)], is_loaded)
  end function loaded_dofs
end module sig_load_pattern
