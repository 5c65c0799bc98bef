! SPDX-License-Identifier: BSD-3-Clause
!> Sums over each entry of the deck's contact section: area of the closed contacts, resultant force and moment; with friction also
!> the share of this area that slips, and the work of friction.
module sig_resultant_map
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan, ieee_quiet_nan, ieee_value
  use sig_contact_laws, only: contact_laws_t
  use sig_errors, only: error_t
  use sig_hdf5_reader, only: h5_reader_t
  use sig_hdf5_writer, only: h5_writer_t
  use sig_kinds, only: rk
  use sig_missing_parts, only: fill_missing
  use sig_shape_checks, only: are_indices, is_matrix
  use sig_text, only: string_t
  implicit none(type, external)
  private
  public :: resultant_map_t

  !> The resultants are linear in the multipliers, because geometry and normals are those of the undeformed mesh. They sum normal
  !> and tangential forces: friction is in them. Forces act on the first surface that the entry names, also where the rows belong to
  !> the second one. The moment about the origin is x cross f:
  !> three numbers in space, x f_y - y f_x in the plane. In axisymmetry both are sums over the full turn of components in the half
  !> plane r, z: F_r is the sum of the radial forces, though these have no resultant in space, and r f_z - z f_r shows at which
  !> radius F_z acts.
  type :: resultant_map_t
    !> names of the two surfaces, or of surface and obstacle, of each entry of the deck's contact section; shape (n_entries), or (0)
    !> in older files
    type(string_t), allocatable :: names(:)
    !> entry of each multiplier, 1-based, shape (n_multipliers)
    integer, allocatable :: entries(:)
    !> [-] force of a multiplier of 1, shape (n_dim, n_multipliers)
    real(rk), allocatable :: unit_forces(:, :)
    !> [length] moment of a multiplier of 1, shape (1 or 3, n_multipliers)
    real(rk), allocatable :: unit_moments(:, :)
    !> [length] moment of the forces on both surfaces together, same shape; NaN in older files
    real(rk), allocatable :: unit_imbalances(:, :)
  contains
    procedure :: n_entries
    procedure :: n_moments
    procedure :: sum_areas
    procedure :: evaluate
    procedure :: has_friction
    procedure :: slip_shares
    procedure :: dissipations
    procedure :: imbalances
    procedure :: complete
    procedure :: fits
    procedure :: write
    procedure :: read
  end type resultant_map_t

contains

  !> Returns the number of entries of the deck's contact section; 0 for a model from an older file. Requires: complete.
  pure integer function n_entries(self)
    class(resultant_map_t), intent(in) :: self

    n_entries = size(self%names)
  end function n_entries

  !> Returns the number of components of a moment: 3 in space, 1 in the plane and in axisymmetry.
  pure integer function n_moments(self)
    class(resultant_map_t), intent(in) :: self

    n_moments = size(self%unit_moments, 1)
  end function n_moments

  !> Sums for each entry of the deck's contact section the areas of its contacts that are closed: with a force, or tied. If a force
  !> is not a number, the area of its entry is none either. It allocates nothing.
  pure subroutine sum_areas(self, laws, row_areas, forces, areas)
    class(resultant_map_t), intent(in) :: self
    type(contact_laws_t), intent(in) :: laws
    !> [length**2, length in the plane] area of each row; shape (n_multipliers)
    real(rk), intent(in) :: row_areas(:)
    !> [force] of all rows, or of the first ones; at least of all contacts
    real(rk), intent(in) :: forces(:)
    !> [length**2, length in the plane] shape (n_entries)
    real(rk), intent(out) :: areas(:)
    integer :: k

    areas = 0
    do k = 1, laws%n_contacts
      associate (area => areas(self%entries(k)))
        if (forces(k) > 0 .or. laws%is_tied(k)) area = area + row_areas(k)
        if (ieee_is_nan(forces(k))) area = ieee_value(1.0_rk, ieee_quiet_nan)
      end associate
    end do
  end subroutine sum_areas

  !> Computes for each entry of the deck's contact section three sums over its contacts: the area of those that are closed, and the
  !> resultant force, and moment about the origin, on the first surface. Forces and moments sum all multipliers. If a multiplier is
  !> not a number, the results of its entry are not numbers either. It allocates nothing.
  pure subroutine evaluate(self, laws, row_areas, multipliers, areas, forces, moments)
    class(resultant_map_t), intent(in) :: self
    type(contact_laws_t), intent(in) :: laws
    !> [length**2, length in the plane] area of each row, shape (n_multipliers)
    real(rk), intent(in) :: row_areas(:)
    !> [force] same shape
    real(rk), intent(in) :: multipliers(:)
    !> [length**2, length in the plane] shape (n_entries)
    real(rk), intent(out) :: areas(:)
    !> [force] shape (n_dim, n_entries)
    real(rk), intent(out) :: forces(:, :)
    !> [force*length] shape (n_moments, n_entries)
    real(rk), intent(out) :: moments(:, :)
    integer :: i, k

    call self%sum_areas(laws, row_areas, multipliers, areas)
    forces = 0
    moments = 0
    do k = 1, size(self%entries)
      i = self%entries(k)
      forces(:, i) = forces(:, i) + multipliers(k) * self%unit_forces(:, k)
      moments(:, i) = moments(:, i) + multipliers(k) * self%unit_moments(:, k)
    end do
  end subroutine evaluate

  !> Whether contacts of an entry of the deck's contact section may slip with friction.
  pure logical function has_friction(self, laws, i_entry)
    class(resultant_map_t), intent(in) :: self
    type(contact_laws_t), intent(in) :: laws
    !> 1-based
    integer, intent(in) :: i_entry

    has_friction = laws%remembers()
    if (has_friction) has_friction = any(laws%have_friction() .and. self%entries(:laws%n_contacts) == i_entry)
  end function has_friction

  !> Returns for each entry of the deck's contact section which share [-] of the area that touches slips; 0 where nothing touches.
  !> Shape (n_entries).
  pure function slip_shares(self, laws, row_areas, multipliers, slips) result(shares)
    class(resultant_map_t), intent(in) :: self
    type(contact_laws_t), intent(in) :: laws
    !> [length**2, length in the plane] shape (n_multipliers)
    real(rk), intent(in) :: row_areas(:)
    !> [force] same shape
    real(rk), intent(in) :: multipliers(:)
    !> whether each contact slips, shape (n_contacts)
    logical, intent(in) :: slips(:)
    real(rk) :: shares(size(self%names))
    real(rk) :: areas(size(self%names)), slipping(size(self%names))
    integer :: k

    call self%sum_areas(laws, row_areas, multipliers, areas)
    slipping = 0
    do k = 1, size(slips)
      if (.not. slips(k) .or. .not. multipliers(k) > 0) cycle
      slipping(self%entries(k)) = slipping(self%entries(k)) + row_areas(k)
    end do
    shares = 0
    where (areas > 0) shares = slipping / areas
  end function slip_shares

  !> Returns for each entry of the deck's contact section the work [force*length] of its friction since the last time: the sum of
  !> tangential force times slip, with the forces at the end of the step. Shape (n_entries).
  pure function dissipations(self, multipliers, slip) result(work)
    class(resultant_map_t), intent(in) :: self
    !> [force] shape (n_multipliers)
    real(rk), intent(in) :: multipliers(:)
    !> [length] same shape, 0 in normal rows
    real(rk), intent(in) :: slip(:)
    real(rk) :: work(size(self%names))
    integer :: k

    work = 0
    do k = 1, size(self%entries)
      work(self%entries(k)) = work(self%entries(k)) + multipliers(k) * slip(k)
    end do
  end function dissipations

  !> Returns the moments [force*length], about the origin, of the forces on both surfaces of each entry together, shape (n_moments,
  !> n_entries): 0, except for rounding, where the two surfaces balance, and 0 for an obstacle; NaN for a model from an older file.
  pure function imbalances(self, multipliers)
    class(resultant_map_t), intent(in) :: self
    !> [force] shape (n_multipliers)
    real(rk), intent(in) :: multipliers(:)
    real(rk) :: imbalances(size(self%unit_imbalances, 1), size(self%names))
    integer :: k

    imbalances = 0
    do k = 1, size(self%entries)
      associate (of_entry => imbalances(:, self%entries(k)))
        of_entry = of_entry + multipliers(k) * self%unit_imbalances(:, k)
      end associate
    end do
  end function imbalances

  !> Allocates with size 0 each array that is not allocated, as after reading an older file. unit_imbalances become NaN if they are
  !> missing.
  pure subroutine complete(self, n_dim)
    class(resultant_map_t), intent(inout) :: self
    !> number of dimensions of the model
    integer, intent(in) :: n_dim

    call fill_missing(self%names)
    call fill_missing(self%entries)
    call fill_missing(self%unit_forces, n_dim)
    call fill_missing(self%unit_moments, moments_of(n_dim))
    if (allocated(self%unit_imbalances)) return
    allocate (self%unit_imbalances(moments_of(n_dim), size(self%entries)), source=ieee_value(1.0_rk, ieee_quiet_nan))
  end subroutine complete

  !> Whether shapes, entries and values fit a model with these numbers; a map without names must be empty. Values must be finite;
  !> only unit_imbalances may be NaN. Requires: complete, n_dim of 2 or 3.
  pure logical function fits(self, n_dim, n_multipliers)
    class(resultant_map_t), intent(in) :: self
    integer, intent(in) :: n_dim
    integer, intent(in) :: n_multipliers
    integer :: n

    n = n_multipliers
    if (size(self%names) == 0) n = 0
    fits = size(self%entries) == n .and. are_indices(self%entries, size(self%names)) .and. &
      is_matrix(self%unit_forces, n_dim, n) .and. is_matrix(self%unit_moments, moments_of(n_dim), n) .and. &
      all(shape(self%unit_imbalances) == [moments_of(n_dim), n])
    ! NaN in a model that was made before there were imbalances
    fits = fits .and. .not. any(abs(self%unit_imbalances) > huge(1.0_rk))
  end function fits

  !> Returns the number of components of a moment: 3 if n_dim is 3, else 1, as n_dim from a file may have any value.
  pure integer function moments_of(n_dim)
    integer, intent(in) :: n_dim

    moments_of = merge(3, 1, n_dim == 3)
  end function moments_of

  !> Writes the map to the group /contact of a model file. A failure of the file is reported when the file is closed.
  subroutine write(self, file, length)
    class(resultant_map_t), intent(in) :: self
    type(h5_writer_t), intent(inout) :: file
    !> name of the unit of lengths
    character(*), intent(in) :: length

    call file%write('/contact/entry_names', self%names, description='names of the entries of the deck''s contact section')
    call file%write('/contact/entries', self%entries, description='entry of each multiplier, 1-based')
    call file%write('/contact/unit_forces', self%unit_forces, '1', &
      'resultant on the first surface of a multiplier of 1, a multiplier per row')
    call file%write('/contact/unit_moments', self%unit_moments, length, &
      'moment of this force about the origin, on the undeformed mesh, a multiplier per row')
    call file%write('/contact/unit_imbalances', self%unit_imbalances, length, &
      'sum of such moments of the forces on both surfaces, a multiplier per row')
  end subroutine write

  !> Reads the map from the group /contact, then completes it (complete); all arrays become empty if the file has no map. Errors: a
  !> dataset other than unit_imbalances is missing, or a dataset has another type or rank.
  subroutine read(self, file, n_dim, error)
    class(resultant_map_t), intent(inout) :: self
    type(h5_reader_t), intent(in) :: file
    !> number of dimensions of the model
    integer, intent(in) :: n_dim
    type(error_t), allocatable, intent(inout) :: error

    if (file%has('/contact/entry_names')) then
      call file%read('/contact/entry_names', self%names, error)
      call file%read('/contact/entries', self%entries, error)
      call file%read('/contact/unit_forces', self%unit_forces, error)
      call file%read('/contact/unit_moments', self%unit_moments, error)
      if (file%has('/contact/unit_imbalances')) call file%read('/contact/unit_imbalances', self%unit_imbalances, error)
    end if
    call self%complete(n_dim)
  end subroutine read
end module sig_resultant_map
