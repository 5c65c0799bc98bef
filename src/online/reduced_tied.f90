! SPDX-License-Identifier: BSD-3-Clause
!> A large contact as a kind of reduced model: it gives exact forces on all contacts, where only the trained rows change between
!> open and closed.
!>
!> A query solves for the changing rows in the cluster of the nearest training point. It then checks that the forces of the rows
!> taken as closed are not negative, and that the rows taken as open do not penetrate. If this is not so, the other clusters are
!> tried one after the other. If no cluster can answer, there is no answer.
module sig_reduced_tied
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use sig_answer, only: answer_condensed, answer_t, comparable_size
  use sig_bits, only: unpack_bits
  use sig_description_line, only: line, modes_text
  use sig_gradient, only: gradient_t
  use sig_kinds, only: rk
  use sig_lcp_derivative, only: differentiate_lcp, lcp_derivative_t
  use sig_lcp, only: lcp_solution_t, lcp_workspace_t, solve_lcp
  use sig_linear_algebra, only: multiply
  use sig_reasons, only: reason_outside
  use sig_reduced, only: neighbors_t, reduced_t, room_t
  use sig_reduced_exact, only: displacement_text, not_unique
  use sig_shape_checks, only: place_in_ascending
  use sig_text, only: counted, to_text
  use sig_tied_data, only: row_changing, row_closed, tied_cluster_t, tied_data_t
  implicit none(type, external)
  private
  public :: reduced_tied_t

  !> Prepared data of a cluster, in addition to those in the file.
  type :: prepared_t
    !> changing rows, 1-based
    integer, allocatable :: changing(:)
    !> [length/force] operator of the changing rows, shape (n_changing, n_changing)
    real(rk), allocatable :: compliance(:, :)
  end type prepared_t

  type, extends(tied_data_t) :: reduced_tied_t
    type(prepared_t), allocatable, private :: prepared(:)
  contains
    procedure :: kind => kind_of
    procedure :: prepare
    procedure :: create_room
    procedure :: solve
    procedure :: fill_displacement
    procedure :: displacement_of_dof
    procedure :: describe
    procedure :: differentiate
    procedure :: displacement_changes
  end type reduced_tied_t

  type, extends(room_t) :: tied_room_t
    type(lcp_workspace_t) :: workspace
    type(lcp_solution_t) :: solution
    !> [force or length] of all rows, shape (n_multipliers)
    real(rk), allocatable :: rows(:)
    logical, allocatable :: start(:)
  end type tied_room_t

  !> [-] a value of the wrong sign, of at most this share of the largest value of its kind, counts as rounding
  real(rk), parameter :: rounding = 1.0e-10_rk

contains

  pure function kind_of(self) result(name)
    class(reduced_tied_t), intent(in) :: self
    character(:), allocatable :: name

    name = 'tied'
  end function kind_of

  !> Computes for each cluster the list of its changing rows and their matrix, which is `operator` in these rows, made exactly
  !> symmetric. There are no errors: message stays unallocated.
  subroutine prepare(self, message)
    class(reduced_tied_t), intent(inout) :: self
    character(:), allocatable, intent(out) :: message
    integer :: i, k

    if (allocated(self%prepared)) deallocate (self%prepared)
    allocate (self%prepared(size(self%clusters)))
    do i = 1, size(self%prepared)
      associate (cluster => self%clusters(i), prepared => self%prepared(i))
        prepared%changing = pack([(k, k=1, size(cluster%status))], cluster%status == row_changing)
        prepared%compliance = cluster%operator(prepared%changing, :)
        ! the matrix is symmetric except for rounding
        prepared%compliance = (prepared%compliance + transpose(prepared%compliance)) / 2
      end associate
    end do
  end subroutine prepare

  !> Makes the work arrays for one thread.
  subroutine create_room(self, room)
    class(reduced_tied_t), intent(in) :: self
    class(room_t), allocatable, intent(out) :: room
    type(tied_room_t), allocatable :: own

    allocate (own)
    allocate (own%rows(self%n_rows()), own%start(self%n_rows()))
    call move_alloc(own, room)
  end subroutine create_room

  !> Solves in the cluster of the nearest training point, then in the others one after the other, until one can answer. Without a
  !> nearest training point the first cluster comes first. If none can answer, the reason tells why the last one could not:
  !> reason_outside, or that of solve_lcp. The arguments are those of solve_at in sig_reduced; `judge` is not used.
  subroutine solve(self, theta, near, judge, room, answer)
    class(reduced_tied_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    type(neighbors_t), intent(in) :: near
    class(reduced_t), pointer, intent(in) :: judge
    class(room_t), intent(inout) :: room
    type(answer_t), intent(inout) :: answer
    integer :: first, i

    select type (room)
    type is (tied_room_t)
      first = 1
      room%start = .false.
      if (near%nearest >= 1 .and. near%nearest <= size(self%cluster_of_point)) then
        first = self%cluster_of_point(near%nearest)
        call unpack_bits(self%start_sets(:, near%nearest), room%start)
      end if
      do i = 0, size(self%clusters) - 1
        call solve_cluster(self, modulo(first - 1 + i, size(self%clusters)) + 1, theta, room, answer)
        if (answer%reason > 0) return
      end do
    end select
  end subroutine solve

  !> Solves for the changing rows of a cluster from the active set in room%start, then checks its other rows (is_inside). The reason
  !> is that of solve_lcp, or reason_outside if another row has the wrong sign. With an answer, row_cluster becomes this cluster,
  !> and the forces of all contacts are set.
  subroutine solve_cluster(self, i, theta, room, answer)
    class(reduced_tied_t), intent(in) :: self
    !> number of the cluster, 1-based
    integer, intent(in) :: i
    real(rk), contiguous, intent(in) :: theta(:)
    type(tied_room_t), intent(inout) :: room
    type(answer_t), intent(inout) :: answer
    integer :: k

    associate (cluster => self%clusters(i), changing => self%prepared(i)%changing)
      call multiply(1.0_rk, cluster%free, theta, 0.0_rk, room%rows)
      call solve_lcp(self%prepared(i)%compliance, room%rows(changing), room%start(changing), room%solution, room%workspace)
      call answer%take_solution(room%solution, answer_condensed)
      if (answer%reason < 0) return
      call multiply(1.0_rk, cluster%operator, room%solution%lambda, 1.0_rk, room%rows)
      if (.not. is_inside(cluster, room%rows)) then
        answer%reason = reason_outside
        answer%n_solutions = 0
        return
      end if
      answer%row_cluster = i
      do k = 1, size(room%rows)
        answer%multipliers(k) = merge(max(0.0_rk, room%rows(k)), 0.0_rk, cluster%status(k) == row_closed)
      end do
      answer%multipliers(changing) = room%solution%lambda
    end associate
    call answer%take_all_forces()
    if (self%has_displacement()) call bound_displacement(self, i, answer)
  end subroutine solve_cluster

  !> Sets displacement_bound and relative_displacement_bound: the error of the modes, and rounding. The forces are those of the
  !> full-order problem, or there is no answer.
  subroutine bound_displacement(self, i, answer)
    class(reduced_tied_t), intent(in) :: self
    !> cluster that answered
    integer, intent(in) :: i
    type(answer_t), intent(inout) :: answer
    real(rk) :: energy, forces(size(self%prepared(i)%changing)), square

    forces = answer%multipliers(self%prepared(i)%changing)
    associate (cluster => self%clusters(i), theta => answer%theta, compliance => self%prepared(i)%compliance)
      energy = dot_product(forces, matmul(compliance, forces))
      square = energy
      if (self%has_modes()) square = energy + dot_product(theta, matmul(cluster%free_energy, theta)) - &
        2 * dot_product(forces, matmul(cluster%shared_energy, theta))
      associate (size_of_field => comparable_size(sqrt(max(square, 0.0_rk)), self%largest_field))
        call answer%take_displacement_bound(cluster%modes%error_of(forces, energy) + rounding * size_of_field, &
          size_of_field)
      end associate
    end associate
  end subroutine bound_displacement

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
    is_inside = all(smallest >= -rounding * largest)
  end function is_inside

  !> Computes the displacement [length] of all dofs; it is NaN for dofs that are not exact if there are no modes, and for all dofs
  !> without an answer.
  subroutine fill_displacement(self, answer, displacement)
    class(reduced_tied_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    real(rk), contiguous, intent(inout) :: displacement(:)

    displacement = ieee_value(1.0_rk, ieee_quiet_nan)
    if (answer%row_cluster == 0) return
    call fill_field(self, answer%row_cluster, answer%theta, answer%multipliers(self%prepared(answer%row_cluster)%changing), &
      displacement)
  end subroutine fill_displacement

  !> Computes what is linear in the terms and in the forces on the changing rows of a cluster: the displacement, or its change.
  subroutine fill_field(self, i, theta, forces, displacement)
    class(reduced_tied_t), intent(in) :: self
    !> cluster
    integer, intent(in) :: i
    real(rk), contiguous, intent(in) :: theta(:)
    real(rk), contiguous, intent(in) :: forces(:)
    !> [length] shape (n_dofs); NaN for dofs that are not exact stay if there are no modes
    real(rk), contiguous, intent(inout) :: displacement(:)
    real(rk) :: exact(size(self%exact_dofs))

    associate (cluster => self%clusters(i))
      if (self%has_modes()) then
        call multiply(1.0_rk, cluster%free_field, theta, 0.0_rk, displacement)
        exact = displacement(self%exact_dofs)
        call cluster%modes%subtract_from([integer ::], forces, displacement)
      else
        call multiply(1.0_rk, cluster%free_field, theta, 0.0_rk, exact)
      end if
      call multiply(1.0_rk, cluster%field, forces, 1.0_rk, exact)
    end associate
    displacement(self%exact_dofs) = exact
  end subroutine fill_field

  !> Returns the displacement [length] of one dof, 1-based; NaN if the dof is not exact and there are no modes, or there is no
  !> answer.
  pure real(rk) function displacement_of_dof(self, answer, dof) result(displacement)
    class(reduced_tied_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    integer, intent(in) :: dof
    integer :: i

    displacement = ieee_value(1.0_rk, ieee_quiet_nan)
    i = place_in_ascending(self%exact_dofs, dof)
    if (answer%row_cluster == 0 .or. (i == 0 .and. .not. self%has_modes())) return
    associate (cluster => self%clusters(answer%row_cluster), changing => self%prepared(answer%row_cluster)%changing)
      displacement = dot_product(cluster%free_field(merge(dof, i, self%has_modes()), :), answer%theta)
      if (i > 0) then
        displacement = displacement + dot_product(cluster%field(i, :), answer%multipliers(changing))
      else
        displacement = displacement - cluster%modes%dof_value([integer ::], answer%multipliers(changing), dof)
      end if
    end associate
  end function displacement_of_dof

  !> Computes the derivatives of the multipliers with respect to each parameter. Those of the changing rows are solved for, those of
  !> the closed rows follow from them, and open rows stay without force. Errors: message is allocated if the contact forces are not
  !> unique, or the problem of the contacts that graze has no solution. Requires: an answer of this part. Arguments: no_derivative
  !> in sig_reduced.
  subroutine differentiate(self, answer, gradient, message)
    class(reduced_tied_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    type(gradient_t), intent(inout) :: gradient
    character(:), allocatable, intent(out) :: message
    real(rk), allocatable :: changes(:, :), opening(:), rows(:, :), terms(:)
    type(lcp_derivative_t) :: derivative
    integer :: k

    associate (cluster => self%clusters(answer%row_cluster), prepared => self%prepared(answer%row_cluster))
      rows = matmul(cluster%free, gradient%theta)
      opening = matmul(cluster%free(prepared%changing, :), answer%theta)
      terms = matmul(abs(cluster%free(prepared%changing, :)), abs(answer%theta))
      changes = gradient%direction * rows(prepared%changing, :)
      call differentiate_lcp(prepared%compliance, opening, gradient%sizes(terms, changes), &
        answer%multipliers(prepared%changing), changes, derivative)
      if (derivative%is_singular) then
        message = not_unique
        return
      end if
      call gradient%take(derivative)
      gradient%multipliers = rows + matmul(cluster%operator, gradient%unknowns)
      do k = 1, self%n_rows()
        if (cluster%status(k) /= row_closed) gradient%multipliers(k, :) = 0
      end do
      gradient%multipliers(prepared%changing, :) = gradient%unknowns
    end associate
  end subroutine differentiate

  !> Computes the derivatives of the displacement of the given dofs with respect to one parameter; NaN for a dof that is not exact
  !> if there are no modes.
  !> Arguments: no_changes in sig_reduced.
  subroutine displacement_changes(self, answer, gradient, i_parameter, dofs, changes)
    class(reduced_tied_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    type(gradient_t), intent(in) :: gradient
    integer, intent(in) :: i_parameter
    integer, intent(in) :: dofs(:)
    real(rk), intent(out) :: changes(:)
    real(rk) :: field(max(maxval([0, dofs]), maxval([0, self%exact_dofs]), size(self%clusters(answer%row_cluster)%modes%modes, 1)))

    field = ieee_value(1.0_rk, ieee_quiet_nan)
    call fill_field(self, answer%row_cluster, gradient%theta(:, i_parameter), gradient%unknowns(:, i_parameter), field)
    changes = field(dofs)
  end subroutine displacement_changes

  !> Returns lines about forces, clusters and displacements of the part, each with its line end.
  pure function describe(self) result(text)
    class(reduced_tied_t), intent(in) :: self
    character(:), allocatable :: text
    integer :: i

    text = line('  forces', 'exact on all ' // counted(self%n_rows(), 'contact row') // ', or refused')
    do i = 1, size(self%clusters)
      associate (status => self%clusters(i)%status)
        text = text // line('  contacts, cluster ' // to_text(i), to_text(count(status == row_changing)) // ' change, ' // &
          to_text(count(status == row_closed)) // ' always closed, the others always open')
      end associate
    end do
    text = text // line('  displacements', displacement_text(self%exact_boundaries, size(self%exact_dofs), modes_of_clusters(self)))
  end function describe

  !> Returns how displacements of dofs that are not exact are found, for descriptions: by the largest number of modes of a cluster.
  pure function modes_of_clusters(self) result(text)
    type(reduced_tied_t), intent(in) :: self
    character(:), allocatable :: text
    integer :: i

    text = modes_text(maxval([0, [(size(self%clusters(i)%modes%modes, 2), i=1, size(self%clusters))]]))
  end function modes_of_clusters
end module sig_reduced_tied
