! SPDX-License-Identifier: BSD-3-Clause
!> What the contacts of a problem do: they open and close, with friction or without, or they are tied.
module sig_contact_laws
  use sig_friction_types, only: friction_contacts_t
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: contact_laws_t, laws_without_friction

  !> The contacts with their normal rows, their tangential rows and their coefficients of friction.
  type, extends(friction_contacts_t) :: contact_laws_t
    !> which of its contact's tangents each tangential force has, 1 or 2; shape as tangents
    integer, allocatable :: directions(:, :)
    !> [-] the coefficient of friction of a contact is friction_factors * theta(friction_terms); the factor is 0 without friction;
    !> shapes (n_contacts)
    real(rk), allocatable :: friction_factors(:)
    integer, allocatable :: friction_terms(:)
  contains
    procedure :: is_plain
    procedure :: remembers
    procedure :: have_friction
    procedure :: are_closed
    procedure :: friction_at
    procedure :: has_negative_friction
    procedure :: contacts_of_forces
    procedure :: of_contacts
  end type contact_laws_t

contains

  !> Returns the laws of contacts that open and close without friction.
  pure type(contact_laws_t) function laws_without_friction(n_contacts) result(laws)
    integer, intent(in) :: n_contacts

    laws%n_contacts = n_contacts
    allocate (laws%tangents(2, n_contacts), laws%directions(2, n_contacts), source=0)
    allocate (laws%is_tied(n_contacts), source=.false.)
    allocate (laws%friction_factors(n_contacts), source=0.0_rk)
    allocate (laws%friction_terms(n_contacts), source=1)
  end function laws_without_friction

  !> Whether all contacts only open and close: no friction, none tied. Also true where no laws are set.
  pure logical function is_plain(self)
    class(contact_laws_t), intent(in) :: self

    is_plain = .not. allocated(self%tangents)
    if (.not. is_plain) is_plain = .not. (any(self%tangents > 0) .or. any(self%is_tied))
  end function is_plain

  !> Whether an answer depends on earlier ones: some contacts may slip with friction. It allocates nothing.
  pure logical function remembers(self)
    class(contact_laws_t), intent(in) :: self
    integer :: k

    remembers = .false.
    if (.not. allocated(self%tangents)) return
    do k = 1, self%n_contacts
      remembers = self%tangents(1, k) > 0 .and. .not. self%is_tied(k)
      if (remembers) return
    end do
  end function remembers

  !> Returns which contacts may slip with friction, shape (n_contacts); a coefficient of 0 is friction, too.
  pure function have_friction(self)
    class(contact_laws_t), intent(in) :: self
    logical :: have_friction(self%n_contacts)

    have_friction = self%tangents(1, :) > 0 .and. .not. self%is_tied
  end function have_friction

  !> Returns which contacts are closed, shape (n_contacts): those with a force, and tied ones, which may be pulled. It allocates
  !> nothing.
  pure function are_closed(self, forces)
    class(contact_laws_t), intent(in) :: self
    !> [force] of all rows, or of the normal rows alone
    real(rk), intent(in) :: forces(:)
    logical :: are_closed(self%n_contacts)

    are_closed = forces(:self%n_contacts) > 0 .or. self%is_tied
  end function are_closed

  !> Whether a coefficient of friction is negative. It allocates nothing.
  pure logical function has_negative_friction(self, theta)
    class(contact_laws_t), intent(in) :: self
    !> [-] shape (n_terms)
    real(rk), intent(in) :: theta(:)
    integer :: k

    do k = 1, self%n_contacts
      has_negative_friction = self%friction_factors(k) * theta(self%friction_terms(k)) < 0
      if (has_negative_friction) return
    end do
    has_negative_friction = .false.
  end function has_negative_friction

  !> Returns the coefficients of friction [-] for given values of the terms, shape (n_contacts).
  pure function friction_at(self, theta) result(friction)
    class(contact_laws_t), intent(in) :: self
    !> [-] shape (n_terms)
    real(rk), intent(in) :: theta(:)
    real(rk) :: friction(self%n_contacts)

    friction = self%friction_factors * theta(self%friction_terms)
  end function friction_at

  !> Returns the contact of each force, 1-based: of normal forces themselves, then of tangential forces; shape (n_forces).
  pure function contacts_of_forces(self) result(contacts)
    class(contact_laws_t), intent(in) :: self
    integer :: contacts(self%n_forces())
    integer :: k

    do k = 1, self%n_contacts
      contacts(self%rows_of(k)) = k
    end do
  end function contacts_of_forces

  !> Returns the laws of some contacts alone. Their forces keep their order: row k is the k-th of the rows of these contacts.
  pure type(contact_laws_t) function of_contacts(self, is_taken) result(laws)
    class(contact_laws_t), intent(in) :: self
    !> shape (n_contacts)
    logical, intent(in) :: is_taken(:)
    integer :: contacts(self%n_forces()), places(0:self%n_forces())
    integer :: i, k, n

    contacts = self%contacts_of_forces()
    places = 0
    n = 0
    do k = 1, size(contacts)
      if (.not. is_taken(contacts(k))) cycle
      n = n + 1
      places(k) = n
    end do
    associate (taken => pack([(k, k=1, self%n_contacts)], is_taken))
      laws%n_contacts = size(taken)
      allocate (laws%tangents(2, size(taken)))
      do i = 1, 2
        laws%tangents(i, :) = places(self%tangents(i, taken))
      end do
      laws%directions = self%directions(:, taken)
      laws%is_tied = self%is_tied(taken)
      laws%friction_factors = self%friction_factors(taken)
      laws%friction_terms = self%friction_terms(taken)
    end associate
  end function of_contacts
end module sig_contact_laws
