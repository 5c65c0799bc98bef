! SPDX-License-Identifier: BSD-3-Clause
!> The data of a tied model: a large contact condensed to the rows that change, cluster by cluster. Training makes them and a file
!> keeps them.
module sig_tied_data
  use sig_bits, only: n_words
  use sig_contact_field, only: contact_field_t
  use sig_errors, only: error_t
  use sig_hdf5_reader, only: h5_reader_t
  use sig_hdf5_writer, only: h5_writer_t
  use sig_kinds, only: rk
  use sig_missing_parts, only: fill_missing
  use sig_reduced, only: model_sizes_t
  use sig_reduced_exact, only: reduced_exact_t
  use sig_shape_checks, only: are_indices, is_matrix
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: tied_cluster_t, tied_data_t

  !> status of a row in a cluster
  integer, parameter, public :: row_open = 0, row_closed = 1, row_changing = 2

  !> One cluster. Each row has a value: its force if it is closed, else its opening. The values of all rows are
  !> free theta + operator lambda, where lambda are the forces of the changing rows.
  type :: tied_cluster_t
    !> row_*, shape (n_multipliers)
    integer, allocatable :: status(:)
    !> [force or length per unit of theta] shape (n_multipliers, n_terms)
    real(rk), allocatable :: free(:, :)
    !> [-] in the closed rows, [length/force] in the others, shape (n_multipliers, n_changing); symmetric in the changing rows
    real(rk), allocatable :: operator(:, :)
    !> [length] displacement of the exact dofs = free_field theta + field lambda: [length per unit of theta] shape (n_exact,
    !> n_terms), where `modes` is there (n_dofs, n_terms), and [length/force] shape (n_exact, n_changing)
    real(rk), allocatable :: free_field(:, :)
    real(rk), allocatable :: field(:, :)
    !> minus the displacement of all dofs under forces on the changing rows, or nothing
    type(contact_field_t) :: modes
    !> [force*length per unit of theta squared] G'K G, shape (n_terms, n_terms), and [length per unit of theta] H'K G, shape
    !> (n_changing, n_terms), for the size of the displacement G theta - H lambda; empty without modes
    real(rk), allocatable :: free_energy(:, :)
    real(rk), allocatable :: shared_energy(:, :)
  end type tied_cluster_t

  type, abstract, extends(reduced_exact_t) :: tied_data_t
    type(tied_cluster_t), allocatable :: clusters(:)
    !> cluster of each training point, 1-based, shape (n_points)
    integer, allocatable :: cluster_of_point(:)
    !> [sqrt(force*length)] largest size of the displacement in training, in the norm of the stiffness
    real(rk) :: largest_field = 0
  contains
    procedure :: complete
    procedure :: mismatch
    procedure :: n_rows
    procedure :: has_modes
    procedure :: write
    procedure :: read
  end type tied_data_t

contains

  !> Allocates with size 0 each array of this type and of its base types that is not allocated; of a cluster those for displacements
  !> of all dofs.
  pure subroutine complete(self, sizes)
    class(tied_data_t), intent(inout) :: self
    type(model_sizes_t), intent(in) :: sizes
    integer :: i

    call self%complete_shared(sizes)
    if (.not. allocated(self%clusters)) allocate (self%clusters(0))
    do i = 1, size(self%clusters)
      if (.not. allocated(self%clusters(i)%status)) cycle
      call self%clusters(i)%modes%complete(sizes%n_dofs, count(self%clusters(i)%status == row_changing))
      if (.not. allocated(self%clusters(i)%free_energy)) allocate (self%clusters(i)%free_energy(0, 0))
      if (.not. allocated(self%clusters(i)%shared_energy)) allocate (self%clusters(i)%shared_energy(0, 0))
    end do
    call fill_missing(self%cluster_of_point)
  end subroutine complete

  !> Returns the name of an array of this type, of its base types or of a cluster, whose shape or values do not fit the model;
  !> `tied` if there are no clusters, and empty when all fit. Requires: complete; the arrays of the clusters are allocated.
  pure function mismatch(self, sizes) result(name)
    class(tied_data_t), intent(in) :: self
    type(model_sizes_t), intent(in) :: sizes
    character(:), allocatable :: name
    integer :: i, n_changing, n_energies, n_fields

    name = self%shared_mismatch(sizes)
    if (size(self%clusters) == 0) name = 'tied'
    if (any(shape(self%start_sets) /= [n_words(sizes%n_multipliers), sizes%n_points])) name = 'start_sets'
    if (size(self%cluster_of_point) /= sizes%n_points .or. .not. are_indices(self%cluster_of_point, size(self%clusters))) &
      name = 'cluster_of_point'
    do i = 1, size(self%clusters)
      associate (cluster => self%clusters(i), n => sizes%n_multipliers, n_exact => size(self%exact_dofs))
        n_changing = count(cluster%status == row_changing)
        if (size(cluster%status) /= n .or. any(cluster%status < row_open .or. cluster%status > row_changing)) name = 'tied/status'
        if (.not. is_matrix(cluster%free, n, sizes%n_terms)) name = 'tied/free'
        if (.not. is_matrix(cluster%operator, n, n_changing)) name = 'tied/operator'
        n_fields = merge(sizes%n_dofs, n_exact, cluster%modes%is_there())
        n_energies = merge(sizes%n_terms, 0, cluster%modes%is_there())
        if (.not. is_matrix(cluster%free_field, n_fields, sizes%n_terms)) name = 'tied/free_field'
        if (.not. is_matrix(cluster%field, n_exact, n_changing)) name = 'tied/field'
        if (.not. is_matrix(cluster%free_energy, n_energies, n_energies)) name = 'tied/free_energy'
        if (.not. is_matrix(cluster%shared_energy, merge(n_changing, 0, n_energies > 0), n_energies)) name = 'tied/shared_energy'
        if (name == '' .and. cluster%modes%mismatch(sizes%n_dofs, n_changing, 0) /= '') name = 'tied/modes'
        if (name == '' .and. (cluster%modes%is_there() .neqv. self%clusters(1)%modes%is_there())) name = 'tied/modes'
      end associate
    end do
  end function mismatch

  !> Returns the number of contact rows; 0 without clusters.
  pure integer function n_rows(self)
    class(tied_data_t), intent(in) :: self

    n_rows = 0
    if (size(self%clusters) > 0) n_rows = size(self%clusters(1)%status)
  end function n_rows

  !> Whether modes give the displacement of the dofs that are not exact.
  pure logical function has_modes(self)
    class(tied_data_t), intent(in) :: self

    has_modes = .false.
    if (size(self%clusters) > 0) has_modes = self%clusters(1)%modes%is_there()
  end function has_modes

  !> Writes the data to a group of a model file. A failure of the file is reported when the file is closed.
  subroutine write(self, file, group, length, force)
    class(tied_data_t), intent(in) :: self
    type(h5_writer_t), intent(inout) :: file
    character(*), intent(in) :: group
    !> names of the units
    character(*), intent(in) :: length
    character(*), intent(in) :: force
    integer :: i

    call self%write_shared(file, group)
    call file%write(group // '/cluster_of_point', self%cluster_of_point, description='cluster (1-based) of each training point')
    call file%write(group // '/largest_field', self%largest_field, 'sqrt(' // force // '*' // length // ')', &
      'largest size of the displacement in training, in the norm of the stiffness')
    do i = 1, size(self%clusters)
      associate (cluster => self%clusters(i), place => group // '/tied/' // to_text(i))
        call file%write(place // '/status', cluster%status, description='status of each contact: 0 open, 1 closed, 2 may change')
        call file%write(place // '/free', cluster%free, description='force (' // force // ') of closed contacts, opening (' // &
          length // ') of the others, without forces on the changing ones; a term per row')
        call file%write(place // '/operator', cluster%operator, description= &
          'what a unit force on each changing contact adds to these forces and openings, a changing contact per row')
        call file%write(place // '/free_field', cluster%free_field, length, &
          'displacement of the exact dofs, with modes of all dofs; a term per row')
        call file%write(place // '/field', cluster%field, length // '/(' // force // ')', &
          'what a unit force on each changing contact adds to this displacement, a changing contact per row')
        call cluster%modes%write(file, place // '/modes', length, force)
        call file%write(place // '/free_energy', cluster%free_energy, force // '*' // length, &
          'work of the forces of each term on the displacement of each term, without forces on the changing contacts')
        call file%write(place // '/shared_energy', cluster%shared_energy, length, &
          'work of a unit force on each changing contact on minus the displacement of each term, a term per row')
      end associate
    end do
  end subroutine write

  !> Reads the data from a group of a model file. The number of clusters is the largest one in cluster_of_point. Errors: a dataset
  !> is missing, or has another type or rank. If the group of a cluster is missing, `clusters` becomes empty; mismatch reports this.
  subroutine read(self, file, group, error)
    class(tied_data_t), intent(inout) :: self
    type(h5_reader_t), intent(in) :: file
    character(*), intent(in) :: group
    type(error_t), allocatable, intent(inout) :: error
    character(:), allocatable :: place
    integer :: i, n_clusters, n_found

    call self%read_shared(file, group, error)
    call file%read(group // '/cluster_of_point', self%cluster_of_point, error)
    call file%read(group // '/largest_field', self%largest_field, error)
    if (allocated(error)) return
    ! the number of clusters is the largest one that the points name, because a number in the file may have any value
    n_clusters = maxval([0, self%cluster_of_point])
    n_found = file%count_groups(group // '/tied', n_clusters)
    if (n_found < n_clusters) n_clusters = 0
    allocate (self%clusters(n_clusters))
    do i = 1, n_clusters
      place = group // '/tied/' // to_text(i)
      call file%read(place // '/status', self%clusters(i)%status, error)
      call file%read(place // '/free', self%clusters(i)%free, error)
      call file%read(place // '/operator', self%clusters(i)%operator, error)
      call file%read(place // '/free_field', self%clusters(i)%free_field, error)
      call file%read(place // '/field', self%clusters(i)%field, error)
      call self%clusters(i)%modes%read(file, place // '/modes', error)
      call file%read(place // '/free_energy', self%clusters(i)%free_energy, error)
      call file%read(place // '/shared_energy', self%clusters(i)%shared_energy, error)
    end do
  end subroutine read
end module sig_tied_data
