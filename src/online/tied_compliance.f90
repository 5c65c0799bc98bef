! SPDX-License-Identifier: BSD-3-Clause
!> A large contact of which only the rows that change are unknowns, cluster by cluster. Training makes the data and a file keeps
!> them.
!>
!> Each cluster is a system. Its solution is one of the whole problem if the forces of the rows taken as closed are not negative,
!> and the rows taken as open do not penetrate.
!>
!> With friction, a closed contact sticks from the beginning of a history on: its tangential rows are tied, too, at the place 0 from
!> which its first slip would count. This holds as long as its tangential force is within the limit of Coulomb's law. Tied surfaces
!> are always closed, whatever their forces are. There is one cluster then, because the states of a history follow each other.
module sig_tied_compliance
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use sig_answer, only: answer_t
  use sig_bits, only: unpack_bits
  use sig_compliance, only: compliance_point_t, compliance_t
  use sig_contact_laws, only: contact_laws_t, laws_without_friction
  use sig_description_line, only: line, modes_text
  use sig_errors, only: error_t
  use sig_fixed_compliance, only: fixed_compliance_t
  use sig_gradient, only: gradient_t
  use sig_hdf5_reader, only: h5_reader_t
  use sig_hdf5_writer, only: h5_writer_t
  use sig_kinds, only: rk
  use sig_linear_algebra, only: multiply
  use sig_missing_parts, only: fill_missing
  use sig_model_data, only: model_sizes_t
  use sig_shape_checks, only: are_indices, is_matrix
  use sig_text, only: counted, to_text
  implicit none(type, external)
  private
  public :: tied_cluster_t, tied_compliance_t

  !> status of a row in a cluster; the rows of a contact have the same
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
    !> the problem of the changing rows alone, with the displacement under their forces; its W, q and exact dofs are from `prepare`
    type(fixed_compliance_t) :: inner
    !> changing rows, 1-based, from `prepare`
    integer, allocatable, private :: changing(:)
  end type tied_cluster_t

  type, extends(compliance_t) :: tied_compliance_t
    type(tied_cluster_t), allocatable :: clusters(:)
    !> of all contacts; `complete` sets them
    type(contact_laws_t), private :: laws
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
    procedure :: expand_step
    procedure :: expand_changes
    procedure :: laws_of_unknowns
    procedure :: opening_terms
    procedure :: drop_rounding
    procedure :: change_openings
    procedure :: fill_displacement
    procedure :: displacement_of_dof
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
    self%laws = sizes%laws
    if (.not. allocated(self%laws%tangents)) self%laws = laws_without_friction(sizes%n_multipliers)
    if (.not. allocated(self%clusters)) allocate (self%clusters(0))
    do i = 1, size(self%clusters)
      if (.not. allocated(self%clusters(i)%status)) cycle
      associate (inner => self%clusters(i)%inner)
        call inner%field%complete(sizes%n_dofs, count(self%clusters(i)%status == row_changing))
        if (.not. allocated(inner%free_energy)) allocate (inner%free_energy(0, 0))
        if (.not. allocated(inner%shared_energy)) allocate (inner%shared_energy(0, 0))
      end associate
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
    if (size(self%cluster_of_point) /= sizes%n_points .or. .not. are_indices(self%cluster_of_point, size(self%clusters))) &
      name = 'cluster_of_point'
    do i = 1, size(self%clusters)
      associate (cluster => self%clusters(i), inner => self%clusters(i)%inner, n => sizes%n_multipliers, &
        n_exact => size(self%exact_dofs))
        n_changing = count(cluster%status == row_changing)
        if (size(cluster%status) /= n .or. any(cluster%status < row_open .or. cluster%status > row_changing)) then
          name = 'tied/status'
        else if (.not. sizes%laws%is_plain()) then
          if (any(cluster%status /= cluster%status(sizes%laws%contacts_of_forces()))) name = 'tied/status'
        end if
        if (.not. is_matrix(cluster%free, n, sizes%n_terms)) name = 'tied/free'
        if (.not. is_matrix(cluster%operator, n, n_changing)) name = 'tied/operator'
        n_fields = merge(sizes%n_dofs, n_exact, inner%has_modes())
        n_energies = merge(sizes%n_terms, 0, inner%has_modes())
        if (.not. is_matrix(inner%free_response, n_fields, sizes%n_terms)) name = 'tied/free_field'
        if (.not. is_matrix(inner%contact_response, n_exact, n_changing)) name = 'tied/field'
        if (.not. is_matrix(inner%free_energy, n_energies, n_energies)) name = 'tied/free_energy'
        if (.not. is_matrix(inner%shared_energy, merge(n_changing, 0, n_energies > 0), n_energies)) name = 'tied/shared_energy'
        if (name == '' .and. inner%field%mismatch(sizes%n_dofs, n_changing, 0) /= '') name = 'tied/modes'
        if (name == '' .and. (inner%has_modes() .neqv. self%has_modes())) name = 'tied/modes'
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
    if (size(self%clusters) > 0) has_modes = self%clusters(1)%inner%has_modes()
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
      associate (cluster => self%clusters(i), inner => self%clusters(i)%inner, place => group // '/tied/' // to_text(i))
        call file%write(place // '/status', cluster%status, description='status of each contact: 0 open, 1 closed, 2 may change')
        call file%write(place // '/free', cluster%free, description='force (' // force // ') of closed contacts, opening (' // &
          length // ') of the others, without forces on the changing ones; a term per row')
        call file%write(place // '/operator', cluster%operator, description= &
          'what a unit force on each changing contact adds to these forces and openings, a changing contact per row')
        call file%write(place // '/free_field', inner%free_response, length, &
          'displacement of the exact dofs, with modes of all dofs; a term per row')
        call file%write(place // '/field', -inner%contact_response, length // '/(' // force // ')', &
          'what a unit force on each changing contact adds to this displacement, a changing contact per row')
        call inner%field%write(file, place // '/modes', length, force)
        call file%write(place // '/free_energy', inner%free_energy, force // '*' // length, &
          'work of the forces of each term on the displacement of each term, without forces on the changing contacts')
        call file%write(place // '/shared_energy', inner%shared_energy, length, &
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
    integer :: i

    call self%read_shared(file, group, error)
    self%anchors = [integer ::]
    call file%read(group // '/cluster_of_point', self%cluster_of_point, error)
    if (allocated(error)) return
    ! the number of clusters is the largest one that the points name, because a number in the file may have any value
    allocate (self%clusters(file%all_groups(group // '/tied', maxval([0, self%cluster_of_point]))))
    do i = 1, size(self%clusters)
      place = group // '/tied/' // to_text(i)
      call file%read(place // '/status', self%clusters(i)%status, error)
      call file%read(place // '/free', self%clusters(i)%free, error)
      call file%read(place // '/operator', self%clusters(i)%operator, error)
      associate (inner => self%clusters(i)%inner)
        call file%read(place // '/free_field', inner%free_response, error)
        call file%read(place // '/field', inner%contact_response, error)
        if (allocated(inner%contact_response)) inner%contact_response = -inner%contact_response
        call inner%field%read(file, place // '/modes', error)
        call file%read(place // '/free_energy', inner%free_energy, error)
        call file%read(place // '/shared_energy', inner%shared_energy, error)
      end associate
    end do
  end subroutine read

  pure function describe(self) result(text)
    class(tied_compliance_t), intent(in) :: self
    character(:), allocatable :: text
    integer :: i

    text = line('  forces', 'exact on all ' // counted(self%n_rows(), 'contact row') // ', or refused')
    do i = 1, size(self%clusters)
      associate (status => self%clusters(i)%status)
        text = text // line('  contacts, cluster ' // to_text(i), counted(count(status == row_changing), 'contact row') // &
          ' may change, ' // to_text(count(status == row_closed)) // ' tied (always closed, with friction also stuck), ' // &
          'the others always open')
      end associate
    end do
    text = text // line('  displacements', self%displacement_text(modes_text(maxval([0, &
      [(size(self%clusters(i)%inner%field%modes, 2), i=1, size(self%clusters))]]))))
  end function describe

  !> Whether there is one cluster: each has a W of its own.
  pure logical function is_fixed(self)
    class(tied_compliance_t), intent(in) :: self

    is_fixed = size(self%clusters) == 1
  end function is_fixed

  !> Computes for each cluster the list of its changing rows, and their W and q. W is `operator` in these rows, made symmetric.
  subroutine prepare(self)
    class(tied_compliance_t), intent(inout) :: self
    integer :: i, k

    do i = 1, size(self%clusters)
      associate (cluster => self%clusters(i), inner => self%clusters(i)%inner)
        cluster%changing = pack([(k, k=1, size(cluster%status))], cluster%status == row_changing)
        inner%compliance = cluster%operator(cluster%changing, :)
        ! the matrix is symmetric except for rounding
        inner%compliance = (inner%compliance + transpose(inner%compliance)) / 2
        inner%free_opening = cluster%free(cluster%changing, :)
        inner%exact_dofs = self%exact_dofs
        inner%anchors = [integer ::]
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

    is_valid = .true.
    associate (cluster => self%clusters(point%i_system))
      call multiply(1.0_rk, cluster%free, theta, 0.0_rk, point%rows)
      point%opening = point%rows(cluster%changing)
    end associate
  end subroutine evaluate

  function matrix(self, point)
    class(tied_compliance_t), target, intent(in) :: self
    type(compliance_point_t), target, intent(in) :: point
    real(rk), pointer, contiguous :: matrix(:, :)

    matrix => self%clusters(point%i_system)%inner%compliance
  end function matrix

  !> Returns the laws of the contacts that may change. Requires: one cluster.
  pure function laws_of_unknowns(self, laws) result(own)
    class(tied_compliance_t), intent(in) :: self
    type(contact_laws_t), intent(in) :: laws
    type(contact_laws_t) :: own

    own = laws%of_contacts(self%clusters(1)%status(:laws%n_contacts) == row_changing)
  end function laws_of_unknowns

  !> Computes the forces of all rows, and checks that the other rows have the right sign (is_inside).
  subroutine expand(self, point, opening, unknowns, forces, is_valid)
    class(tied_compliance_t), intent(in) :: self
    type(compliance_point_t), intent(in) :: point
    real(rk), intent(in) :: opening(:)
    real(rk), contiguous, intent(in) :: unknowns(:)
    real(rk), intent(inout) :: forces(:)
    logical, intent(out) :: is_valid
    real(rk) :: rows(size(point%rows))

    associate (cluster => self%clusters(point%i_system))
      rows = point%rows
      call multiply(1.0_rk, cluster%operator, unknowns, 1.0_rk, rows)
      is_valid = is_inside(self%laws, cluster, rows)
      if (.not. is_valid) return
      forces = merge(max(0.0_rk, rows), 0.0_rk, cluster%status == row_closed)
      forces(cluster%changing) = unknowns
    end associate
  end subroutine expand

  !> Contacts that always stick do not slip; those without friction slip wherever they are closed.
  subroutine expand_step(self, theta, point, answer, is_valid)
    class(tied_compliance_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    type(compliance_point_t), intent(in) :: point
    type(answer_t), intent(inout) :: answer
    logical, intent(out) :: is_valid
    real(rk) :: rows(size(point%rows))

    associate (cluster => self%clusters(point%i_system), laws => self%laws)
      rows = point%rows
      call multiply(1.0_rk, cluster%operator, answer%unknowns(:size(cluster%changing)), 1.0_rk, rows)
      is_valid = is_inside(laws, cluster, rows)
      if (is_valid) is_valid = all_stick(laws, cluster, laws%friction_at(theta), rows)
      if (.not. is_valid) return
      associate (is_changing => cluster%status == row_changing, n => laws%n_contacts)
        rows = merge(rows, 0.0_rk, cluster%status == row_closed)
        where (.not. laws%is_tied) rows(:n) = max(0.0_rk, rows(:n))
        answer%multipliers = unpack(answer%multipliers, is_changing, rows)
        if (.not. laws%remembers()) return
        answer%slip = unpack(answer%slip, is_changing, 0.0_rk)
        answer%slips = unpack(answer%slips, is_changing(:n), rows(:n) > 0 .and. .not. &
          (laws%is_tied .or. laws%friction_factors > 0))
      end associate
    end associate
  end subroutine expand_step

  !> Whether the tangential forces of closed contacts are at most the largest friction. A difference counts as rounding up to 1e-10
  !> of the largest force on closed rows.
  pure logical function all_stick(laws, cluster, friction, rows)
    type(contact_laws_t), intent(in) :: laws
    type(tied_cluster_t), intent(in) :: cluster
    !> [-] coefficient of each contact
    real(rk), intent(in) :: friction(:)
    !> [force] of closed rows, shape (n_multipliers)
    real(rk), intent(in) :: rows(:)
    real(rk) :: rounded
    integer :: k

    rounded = share_of_rounding * maxval([0.0_rk, abs(rows)], mask=[.true., cluster%status == row_closed])
    all_stick = .true.
    do k = 1, laws%n_contacts
      if (cluster%status(k) /= row_closed .or. laws%is_tied(k)) cycle
      all_stick = all_stick .and. norm2(laws%tangential(k, rows)) <= friction(k) * max(0.0_rk, rows(k)) + rounded
    end do
  end function all_stick

  !> Whether the normal forces of closed contacts are not negative, unless these are tied surfaces, and open contacts do not
  !> penetrate. Contacts that may change are not checked. A negative force counts as rounding up to 1e-10 of the largest normal
  !> force on closed contacts, and a penetration up to 1e-10 of the largest opening of the others, changing ones included (absolute
  !> values).
  pure logical function is_inside(laws, cluster, rows)
    type(contact_laws_t), intent(in) :: laws
    type(tied_cluster_t), intent(in) :: cluster
    !> [force] of closed rows, [length] openings of the others, shape (n_multipliers)
    real(rk), intent(in) :: rows(:)
    real(rk) :: largest(0:2), smallest(0:2)
    integer :: k, kind

    largest = 0
    smallest = 0
    do k = 1, laws%n_contacts
      kind = merge(row_closed, 0, cluster%status(k) == row_closed)
      largest(kind) = max(largest(kind), abs(rows(k)))
      if (kind == row_closed .and. laws%is_tied(k)) cycle
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

    terms = self%clusters(point%i_system)%inner%opening_terms(theta, point)
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

    call self%clusters(point%i_system)%inner%change_openings(point, theta, theta_change, unknowns, changes)
  end subroutine change_openings

  !> It is NaN for all dofs without an answer.
  subroutine fill_displacement(self, answer, displacement)
    class(tied_compliance_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    real(rk), contiguous, intent(inout) :: displacement(:)

    displacement = ieee_value(1.0_rk, ieee_quiet_nan)
    if (answer%row_cluster == 0) return
    associate (cluster => self%clusters(answer%row_cluster))
      call cluster%inner%displace(answer%theta, answer%unknowns(:size(cluster%changing)), displacement)
    end associate
  end subroutine fill_displacement

  pure real(rk) function displacement_of_dof(self, answer, dof) result(displacement)
    class(tied_compliance_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    integer, intent(in) :: dof

    displacement = ieee_value(1.0_rk, ieee_quiet_nan)
    if (answer%row_cluster == 0) return
    associate (cluster => self%clusters(answer%row_cluster))
      displacement = cluster%inner%displacement_of(answer%theta, answer%unknowns(:size(cluster%changing)), dof)
    end associate
  end function displacement_of_dof

  subroutine change_field(self, answer, gradient, i_parameter, dofs, changes)
    class(tied_compliance_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    type(gradient_t), intent(in) :: gradient
    integer, intent(in) :: i_parameter
    integer, intent(in) :: dofs(:)
    real(rk), intent(out) :: changes(:)

    call self%clusters(answer%row_cluster)%inner%change_field(answer, gradient, i_parameter, dofs, changes)
  end subroutine change_field

  real(rk) function size_of_field(self, theta, unknowns, energy, point) result(size_of)
    class(tied_compliance_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    real(rk), contiguous, intent(in) :: unknowns(:)
    real(rk), intent(in) :: energy
    type(compliance_point_t), intent(in) :: point

    size_of = self%clusters(point%i_system)%inner%size_of_field(theta, unknowns, energy, point)
  end function size_of_field

  real(rk) function field_error(self, theta, unknowns, energy, point)
    class(tied_compliance_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    real(rk), contiguous, intent(in) :: unknowns(:)
    real(rk), intent(in) :: energy
    type(compliance_point_t), intent(in) :: point

    field_error = self%clusters(point%i_system)%inner%field_error(theta, unknowns, energy, point)
  end function field_error

  !> Sets row_cluster, displacement_bound and relative_displacement_bound. The forces are those of the full-order problem, or there
  !> is no answer.
  subroutine solve_modes(self, point, answer)
    class(tied_compliance_t), intent(in) :: self
    type(compliance_point_t), intent(inout) :: point
    type(answer_t), intent(inout) :: answer

    answer%row_cluster = point%i_system
    if (.not. self%has_displacement()) return
    associate (cluster => self%clusters(point%i_system))
      associate (forces => answer%unknowns(:size(cluster%changing)))
        call self%bound_displacement(0.0_rk, forces, dot_product(forces, matmul(cluster%inner%compliance, forces)), point, answer)
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
