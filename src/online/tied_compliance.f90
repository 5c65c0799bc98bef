! SPDX-License-Identifier: BSD-3-Clause
!> A large contact of which only the rows that change are unknowns, cluster by cluster. Training makes the data and a file keeps
!> them.
!>
!> Each cluster is a system. Its solution is one of the whole problem if the forces of the rows taken as closed are not negative,
!> and the rows taken as open do not penetrate.
module sig_tied_compliance
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use sig_answer, only: answer_t, comparable_size
  use sig_bits, only: n_words, unpack_bits
  use sig_compliance, only: compliance_point_t, compliance_t
  use sig_contact_field, only: contact_field_t
  use sig_description_line, only: line, modes_text
  use sig_errors, only: error_t
  use sig_gradient, only: gradient_t
  use sig_hdf5_reader, only: h5_reader_t
  use sig_hdf5_writer, only: h5_writer_t
  use sig_kinds, only: rk
  use sig_linear_algebra, only: multiply
  use sig_missing_parts, only: fill_missing
  use sig_reduced, only: model_sizes_t
  use sig_shape_checks, only: are_indices, is_matrix, place_in_ascending
  use sig_text, only: counted, to_text
  implicit none(type, external)
  private
  public :: tied_cluster_t, tied_compliance_t

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
    !> changing rows, 1-based, and [length/force] W of these rows, from `prepare`
    integer, allocatable, private :: changing(:)
    real(rk), allocatable, private :: compliance(:, :)
  end type tied_cluster_t

  type, extends(compliance_t) :: tied_compliance_t
    type(tied_cluster_t), allocatable :: clusters(:)
    !> cluster of each training point, 1-based, shape (n_points)
    integer, allocatable :: cluster_of_point(:)
  contains
    procedure :: kind => kind_of
    procedure :: complete
    procedure :: mismatch
    procedure :: write
    procedure :: read
    procedure :: describe
    procedure :: n_rows
    procedure :: has_modes
    procedure :: is_fixed
    procedure :: prepare
    procedure :: n_systems
    procedure :: first_system
    procedure :: start_from
    procedure :: evaluate
    procedure :: matrix
    procedure :: expand
    procedure :: expand_changes
    procedure :: opening_terms
    procedure :: drop_rounding
    procedure :: change_openings
    procedure :: fill_field
    procedure :: field_of_dof
    procedure :: change_field
    procedure :: size_of_field
    procedure :: field_error
    procedure :: solve_modes
    procedure :: has_bound
    procedure :: rounding
  end type tied_compliance_t

  !> [-] a value of the wrong sign, of at most this share of the largest value of its kind, counts as rounding
  real(rk), parameter :: share_of_rounding = 1.0e-10_rk

contains

  pure function kind_of(self) result(text)
    class(tied_compliance_t), intent(in) :: self
    character(:), allocatable :: text

    text = 'tied'
  end function kind_of

  !> Allocates with size 0 each array of this type and of its base types that is not allocated; of a cluster those for displacements
  !> of all dofs.
  pure subroutine complete(self, sizes)
    class(tied_compliance_t), intent(inout) :: self
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
    class(tied_compliance_t), intent(in) :: self
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
    class(tied_compliance_t), intent(in) :: self

    n_rows = 0
    if (size(self%clusters) > 0) n_rows = size(self%clusters(1)%status)
  end function n_rows

  !> Whether modes give the displacement of the dofs that are not exact.
  pure logical function has_modes(self)
    class(tied_compliance_t), intent(in) :: self

    has_modes = .false.
    if (size(self%clusters) > 0) has_modes = self%clusters(1)%modes%is_there()
  end function has_modes

  !> Writes the data to a group of a model file. A failure of the file is reported when the file is closed.
  subroutine write(self, file, group, length, force)
    class(tied_compliance_t), intent(in) :: self
    type(h5_writer_t), intent(inout) :: file
    character(*), intent(in) :: group
    !> names of the units
    character(*), intent(in) :: length
    character(*), intent(in) :: force
    integer :: i

    call self%write_shared(file, group, length, force)
    call file%write(group // '/cluster_of_point', self%cluster_of_point, description='cluster (1-based) of each training point')
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
    class(tied_compliance_t), intent(inout) :: self
    type(h5_reader_t), intent(in) :: file
    character(*), intent(in) :: group
    type(error_t), allocatable, intent(inout) :: error
    character(:), allocatable :: place
    integer :: i, n_clusters, n_found

    call self%read_shared(file, group, error)
    self%anchors = [integer ::]
    call file%read(group // '/cluster_of_point', self%cluster_of_point, error)
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

  pure function describe(self) result(text)
    class(tied_compliance_t), intent(in) :: self
    character(:), allocatable :: text
    integer :: i

    text = line('  forces', 'exact on all ' // counted(self%n_rows(), 'contact row') // ', or refused')
    do i = 1, size(self%clusters)
      associate (status => self%clusters(i)%status)
        text = text // line('  contacts, cluster ' // to_text(i), to_text(count(status == row_changing)) // ' change, ' // &
          to_text(count(status == row_closed)) // ' always closed, the others always open')
      end associate
    end do
    text = text // line('  displacements', self%displacement_text(modes_text(maxval([0, &
      [(size(self%clusters(i)%modes%modes, 2), i=1, size(self%clusters))]]))))
  end function describe

  !> Returns false: each cluster has a W of its own.
  pure logical function is_fixed(self)
    class(tied_compliance_t), intent(in) :: self

    is_fixed = .false.
  end function is_fixed

  !> Computes for each cluster the list of its changing rows and their W, which is `operator` in these rows, made exactly symmetric.
  subroutine prepare(self)
    class(tied_compliance_t), intent(inout) :: self
    integer :: i, k

    do i = 1, size(self%clusters)
      associate (cluster => self%clusters(i))
        cluster%changing = pack([(k, k=1, size(cluster%status))], cluster%status == row_changing)
        cluster%compliance = cluster%operator(cluster%changing, :)
        ! the matrix is symmetric except for rounding
        cluster%compliance = (cluster%compliance + transpose(cluster%compliance)) / 2
      end associate
    end do
  end subroutine prepare

  pure integer function n_systems(self)
    class(tied_compliance_t), intent(in) :: self

    n_systems = size(self%clusters)
  end function n_systems

  !> Returns the cluster of the nearest training point.
  pure integer function first_system(self, nearest)
    class(tied_compliance_t), intent(in) :: self
    integer, intent(in) :: nearest

    first_system = 1
    if (nearest >= 1 .and. nearest <= size(self%cluster_of_point)) first_system = self%cluster_of_point(nearest)
  end function first_system

  !> Sets the active set of the nearest training point at the changing rows; without one, all are open.
  subroutine start_from(self, nearest, point, start)
    class(tied_compliance_t), intent(in) :: self
    integer, intent(in) :: nearest
    type(compliance_point_t), intent(in) :: point
    logical, allocatable, intent(inout) :: start(:)
    logical :: is_closed(self%n_rows())

    is_closed = .false.
    if (nearest >= 1 .and. nearest <= size(self%start_sets, 2)) call unpack_bits(self%start_sets(:, nearest), is_closed)
    start = is_closed(self%clusters(point%i_system)%changing)
  end subroutine start_from

  subroutine evaluate(self, theta, point, is_valid)
    class(tied_compliance_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    type(compliance_point_t), intent(inout) :: point
    logical, intent(out) :: is_valid
    real(rk) :: rows(self%n_rows())

    is_valid = .true.
    associate (cluster => self%clusters(point%i_system))
      call multiply(1.0_rk, cluster%free, theta, 0.0_rk, rows)
      point%opening = rows(cluster%changing)
    end associate
  end subroutine evaluate

  function matrix(self, point)
    class(tied_compliance_t), target, intent(in) :: self
    type(compliance_point_t), target, intent(in) :: point
    real(rk), pointer, contiguous :: matrix(:, :)

    matrix => self%clusters(point%i_system)%compliance
  end function matrix

  !> Computes the forces of all rows, and checks that the other rows have the right sign (is_inside).
  subroutine expand(self, theta, point, opening, unknowns, forces, is_valid)
    class(tied_compliance_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    type(compliance_point_t), intent(in) :: point
    real(rk), intent(in) :: opening(:)
    real(rk), contiguous, intent(in) :: unknowns(:)
    real(rk), intent(inout) :: forces(:)
    logical, intent(out) :: is_valid
    real(rk) :: rows(self%n_rows())

    associate (cluster => self%clusters(point%i_system))
      call multiply(1.0_rk, cluster%free, theta, 0.0_rk, rows)
      call multiply(1.0_rk, cluster%operator, unknowns, 1.0_rk, rows)
      is_valid = is_inside(cluster, rows)
      if (.not. is_valid) return
      forces = merge(max(0.0_rk, rows), 0.0_rk, cluster%status == row_closed)
      forces(cluster%changing) = unknowns
    end associate
  end subroutine expand

  !> Whether the forces of closed rows are not negative, and open rows do not penetrate. Changing rows are not checked. A negative
  !> force counts as rounding up to 1e-10 of the largest force on closed rows, and a penetration up to 1e-10 of the largest opening
  !> of the other rows, changing ones included (absolute values).
  pure logical function is_inside(cluster, rows)
    type(tied_cluster_t), intent(in) :: cluster
    !> [force] of closed rows, [length] openings of the others, shape (n_multipliers)
    real(rk), intent(in) :: rows(:)
    real(rk) :: largest(0:2), smallest(0:2)
    integer :: k, kind

    largest = 0
    smallest = 0
    do k = 1, size(rows)
      kind = merge(row_closed, 0, cluster%status(k) == row_closed)
      largest(kind) = max(largest(kind), abs(rows(k)))
      if (cluster%status(k) /= row_changing) smallest(kind) = min(smallest(kind), rows(k))
    end do
    is_inside = all(smallest >= -share_of_rounding * largest)
  end function is_inside

  !> Those of the closed rows follow from those of the changing rows; open rows stay without force.
  subroutine expand_changes(self, point, gradient)
    class(tied_compliance_t), intent(in) :: self
    type(compliance_point_t), intent(in) :: point
    type(gradient_t), intent(inout) :: gradient
    integer :: k

    associate (cluster => self%clusters(point%i_system))
      gradient%multipliers = matmul(cluster%free, gradient%theta) + matmul(cluster%operator, gradient%unknowns)
      do k = 1, self%n_rows()
        if (cluster%status(k) /= row_closed) gradient%multipliers(k, :) = 0
      end do
      gradient%multipliers(cluster%changing, :) = gradient%unknowns
    end associate
  end subroutine expand_changes

  function opening_terms(self, theta, point) result(terms)
    class(tied_compliance_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    type(compliance_point_t), intent(in) :: point
    real(rk), allocatable :: terms(:)

    associate (cluster => self%clusters(point%i_system))
      terms = matmul(abs(cluster%free(cluster%changing, :)), abs(theta))
    end associate
  end function opening_terms

  !> Does nothing: the size of W of the tied rows, beside which a force would be rounding, is not known.
  subroutine drop_rounding(self, theta, point, unknowns, forces)
    class(tied_compliance_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    type(compliance_point_t), intent(in) :: point
    real(rk), intent(in) :: unknowns(:)
    real(rk), intent(inout) :: forces(:)
  end subroutine drop_rounding

  subroutine change_openings(self, point, theta, theta_change, unknowns, changes)
    class(tied_compliance_t), intent(in) :: self
    type(compliance_point_t), intent(in) :: point
    real(rk), contiguous, intent(in) :: theta(:)
    real(rk), contiguous, intent(in) :: theta_change(:)
    real(rk), contiguous, intent(in) :: unknowns(:)
    real(rk), contiguous, intent(inout) :: changes(:)

    associate (cluster => self%clusters(point%i_system))
      changes = matmul(cluster%free(cluster%changing, :), theta_change)
    end associate
  end subroutine change_openings

  !> It is NaN for all dofs without an answer.
  subroutine fill_field(self, answer, displacement)
    class(tied_compliance_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    real(rk), contiguous, intent(inout) :: displacement(:)

    displacement = ieee_value(1.0_rk, ieee_quiet_nan)
    if (answer%row_cluster == 0) return
    associate (cluster => self%clusters(answer%row_cluster))
      call displace(self, cluster, answer%theta, answer%unknowns(:size(cluster%changing)), displacement)
    end associate
  end subroutine fill_field

  !> Computes what is linear in the terms and in the forces on the changing rows of a cluster: the displacement, or its change.
  subroutine displace(self, cluster, theta, forces, displacement)
    class(tied_compliance_t), intent(in) :: self
    type(tied_cluster_t), intent(in) :: cluster
    real(rk), contiguous, intent(in) :: theta(:)
    !> [force] shape (n_changing)
    real(rk), contiguous, intent(in) :: forces(:)
    !> [length] shape (n_dofs); NaN for dofs that are not exact stay if there are no modes
    real(rk), contiguous, intent(inout) :: displacement(:)
    real(rk) :: exact(size(self%exact_dofs))

    if (cluster%modes%is_there()) then
      call multiply(1.0_rk, cluster%free_field, theta, 0.0_rk, displacement)
      exact = displacement(self%exact_dofs)
      call cluster%modes%subtract_from([integer ::], forces, displacement)
    else
      call multiply(1.0_rk, cluster%free_field, theta, 0.0_rk, exact)
    end if
    call multiply(1.0_rk, cluster%field, forces, 1.0_rk, exact)
    displacement(self%exact_dofs) = exact
  end subroutine displace

  pure real(rk) function field_of_dof(self, answer, dof) result(displacement)
    class(tied_compliance_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    integer, intent(in) :: dof
    integer :: i

    displacement = ieee_value(1.0_rk, ieee_quiet_nan)
    i = place_in_ascending(self%exact_dofs, dof)
    if (answer%row_cluster == 0 .or. (i == 0 .and. .not. self%has_modes())) return
    associate (cluster => self%clusters(answer%row_cluster))
      associate (forces => answer%unknowns(:size(cluster%changing)))
        displacement = dot_product(cluster%free_field(merge(dof, i, self%has_modes()), :), answer%theta)
        if (i > 0) then
          displacement = displacement + dot_product(cluster%field(i, :), forces)
        else
          displacement = displacement - cluster%modes%dof_value([integer ::], forces, dof)
        end if
      end associate
    end associate
  end function field_of_dof

  subroutine change_field(self, answer, gradient, i_parameter, dofs, changes)
    class(tied_compliance_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    type(gradient_t), intent(in) :: gradient
    integer, intent(in) :: i_parameter
    integer, intent(in) :: dofs(:)
    real(rk), intent(out) :: changes(:)
    real(rk) :: field(max(maxval([0, dofs]), maxval([0, self%exact_dofs]), size(self%clusters(answer%row_cluster)%modes%modes, 1)))

    field = ieee_value(1.0_rk, ieee_quiet_nan)
    call displace(self, self%clusters(answer%row_cluster), gradient%theta(:, i_parameter), gradient%unknowns(:, i_parameter), field)
    changes = field(dofs)
  end subroutine change_field

  real(rk) function size_of_field(self, theta, unknowns, energy, point) result(size_of)
    class(tied_compliance_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    real(rk), contiguous, intent(in) :: unknowns(:)
    real(rk), intent(in) :: energy
    type(compliance_point_t), intent(in) :: point
    real(rk) :: square

    square = energy
    associate (cluster => self%clusters(point%i_system))
      if (self%has_modes()) square = energy + dot_product(theta, matmul(cluster%free_energy, theta)) - &
        2 * dot_product(unknowns, matmul(cluster%shared_energy, theta))
    end associate
    size_of = sqrt(max(square, 0.0_rk))
  end function size_of_field

  real(rk) function field_error(self, theta, unknowns, energy, point)
    class(tied_compliance_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    real(rk), contiguous, intent(in) :: unknowns(:)
    real(rk), intent(in) :: energy
    type(compliance_point_t), intent(in) :: point

    field_error = self%clusters(point%i_system)%modes%error_of(unknowns, energy)
  end function field_error

  !> Sets row_cluster, displacement_bound and relative_displacement_bound: the error of the modes, and rounding. The forces are
  !> those of the full-order problem, or there is no answer.
  subroutine solve_modes(self, point, answer)
    class(tied_compliance_t), intent(in) :: self
    type(compliance_point_t), intent(inout) :: point
    type(answer_t), intent(inout) :: answer
    real(rk) :: energy, size_of_field

    answer%row_cluster = point%i_system
    if (.not. self%has_displacement()) return
    associate (cluster => self%clusters(point%i_system))
      associate (forces => answer%unknowns(:size(cluster%changing)))
        energy = dot_product(forces, matmul(cluster%compliance, forces))
        size_of_field = comparable_size(self%size_of_field(answer%theta, forces, energy, point), self%largest_field)
        call answer%take_displacement_bound(self%field_error(answer%theta, forces, energy, point) + &
          self%rounding() * size_of_field, size_of_field)
      end associate
    end associate
  end subroutine solve_modes

  !> Returns false: the forces have no bound of their error.
  pure logical function has_bound(self)
    class(tied_compliance_t), intent(in) :: self

    has_bound = .false.
  end function has_bound

  pure real(rk) function rounding(self)
    class(tied_compliance_t), intent(in) :: self

    rounding = share_of_rounding
  end function rounding
end module sig_tied_compliance
