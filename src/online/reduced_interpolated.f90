! SPDX-License-Identifier: BSD-3-Clause
!> The condensed contact problem of bodies whose elastic constants depend on the parameters, as a kind of reduced model.
!>
!> A query interpolates W and q over the constants, and solves the problem of all contacts from the active set of the nearest
!> training point.
module sig_reduced_interpolated
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use sig_answer, only: answer_condensed, answer_t, comparable_size
  use sig_bits, only: unpack_bits
  use sig_dense_kernels, only: factor_cholesky, reduce_cholesky
  use sig_description_line, only: line, modes_text
  use sig_gradient, only: gradient_t
  use sig_interpolated_certificate, only: bound_foreign_forces, interpolated_energy
  use sig_interpolated_data, only: interpolated_data_t
  use sig_interpolated_derivative, only: differentiate_interpolated, interpolated_displacement_changes, &
    mode_displacement_change
  use sig_interpolated_displacement, only: close_by_modes, fill_interpolated_displacement, &
    interpolated_displacement_of_dof, n_modes_of, solve_modes
  use sig_kinds, only: rk
  use sig_lcp, only: lcp_solution_t, lcp_workspace_t, solve_lcp
  use sig_lcp_rounding, only: drop_forces
  use sig_linear_algebra, only: multiply
  use sig_reasons, only: reason_no_material, reason_pulled_off, reason_ray
  use sig_reduced, only: neighbors_t, reduced_t, room_t
  use sig_reduced_exact, only: count_free, displacement_text, not_unique, pushed, take_forces
  use sig_shape_checks, only: place_in_ascending
  use sig_text, only: counted, short_number, to_text
  implicit none(type, external)
  private
  public :: reduced_interpolated_t

  type, extends(interpolated_data_t) :: reduced_interpolated_t
    !> L of W = L L' at mu_0 without the anchors; empty where W is not needed
    real(rk), allocatable, private :: middle_factor(:, :)
    !> rows that are not anchors
    integer, allocatable, private :: free_rows(:)
  contains
    procedure :: kind => kind_of
    procedure :: prepare
    procedure :: create_room
    procedure :: solve
    procedure, private :: bound_displacement
    procedure :: fill_displacement
    procedure :: displacement_of_dof
    procedure :: n_modes
    procedure :: describe
    procedure, private :: rounding
    procedure :: can_certify
    procedure :: certify
    procedure :: energy
    procedure :: size_in_energy
    procedure :: differentiate
    procedure :: displacement_changes
  end type reduced_interpolated_t

  type, extends(room_t) :: interpolated_room_t
    type(lcp_workspace_t) :: workspace
    type(lcp_solution_t) :: solution
    !> [length/force] W, and [length] q and w, at the point
    real(rk), allocatable :: compliance(:, :)
    real(rk), allocatable :: free_opening(:)
    real(rk), allocatable :: opening(:)
    logical, allocatable :: start(:)
    !> [sqrt(force*length)] residual and field_size from solve_modes
    real(rk) :: residual = 0
    real(rk) :: field_size = 0
  end type interpolated_room_t

  !> [-] smallest rounding error of the factorizations, relative to the size of the answer
  real(rk), parameter :: least_rounding = 1.0e-10_rk

contains

  pure function kind_of(self) result(name)
    class(reduced_interpolated_t), intent(in) :: self
    character(:), allocatable :: name

    name = 'interpolated'
  end function kind_of

  !> Prepares the polynomials of the interpolations. If the data have W at mu_0 (middle_compliance), it is factored without the
  !> anchors for bound_displacement, which gives no bound if this W is not positive definite. There are no errors: message stays
  !> unallocated.
  subroutine prepare(self, message)
    class(reduced_interpolated_t), intent(inout) :: self
    character(:), allocatable, intent(out) :: message
    integer :: i, info

    do i = 1, size(self%bodies)
      call self%bodies(i)%nodes%prepare()
    end do
    self%free_rows = pack([(i, i=1, self%n_rows())], [(all(self%anchors /= i), i=1, self%n_rows())])
    if (allocated(self%middle_factor)) deallocate (self%middle_factor)
    allocate (self%middle_factor(0, 0))
    if (size(self%middle_compliance) == 0) return
    self%middle_factor = self%middle_compliance(self%free_rows, self%free_rows)
    call factor_cholesky(size(self%free_rows), self%middle_factor, info)
    if (info /= 0) self%middle_factor = self%middle_factor(:0, :0)
  end subroutine prepare

  !> Makes the work arrays for one thread.
  subroutine create_room(self, room)
    class(reduced_interpolated_t), intent(in) :: self
    class(room_t), allocatable, intent(out) :: room
    type(interpolated_room_t), allocatable :: own
    integer :: n

    n = self%n_rows()
    allocate (own)
    allocate (own%compliance(n, n), own%free_opening(n), own%opening(n), own%start(n))
    call move_alloc(own, room)
  end subroutine create_room

  !> Solves the complementarity problem of all contacts with W and q of the point. It starts from the active set of the nearest
  !> training point or, without one, from all contacts closed. In a model with modes it then computes the displacement by modes and
  !> bounds its error if it can (bound_displacement); certify replaces this bound where the forces have one. Without an answer the
  !> reason is that of solve_lcp, or reason_no_material for impossible elastic constants; in a problem with anchors reason_ray
  !> becomes reason_pulled_off. Arguments: solve_at in sig_reduced; `judge` is not used.
  subroutine solve(self, theta, near, judge, room, answer)
    class(reduced_interpolated_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    type(neighbors_t), intent(in) :: near
    class(reduced_t), pointer, intent(in) :: judge
    class(room_t), intent(inout) :: room
    type(answer_t), intent(inout) :: answer

    select type (room)
    type is (interpolated_room_t)
      answer%reason = reason_no_material
      if (.not. self%has_material(theta)) return
      call self%evaluate(theta, room%compliance, room%free_opening)
      room%start = .true.
      room%start(self%anchors) = .false.
      if (near%nearest >= 1 .and. near%nearest <= size(self%start_sets, 2)) &
        call unpack_bits(self%start_sets(:, near%nearest), room%start)
      answer%n_iterations = 0
      call solve_lcp(room%compliance, room%free_opening, room%start, room%solution, room%workspace)
      call answer%take_solution(room%solution, answer_condensed)
      answer%unknowns = room%solution%lambda
      if (answer%reason == reason_ray .and. size(self%anchors) > 0) answer%reason = reason_pulled_off
      if (answer%reason <= 0) return
      call take_forces(room%compliance, room%free_opening, self%anchors, self%scale, room%opening, answer)
      call drop_forces(room%compliance, self%opening_terms(theta), self%anchors, self%scale, answer%unknowns, answer%multipliers)
      call count_free(room%compliance, self%anchors, self%scale, answer)
      call answer%take_all_forces()
      if (.not. self%has_modes()) return
      call solve_modes(self, theta, answer%unknowns, answer%coordinates, room%residual, room%field_size)
      call self%bound_displacement(room, answer)
    end select
  end subroutine solve

  !> Sets displacement_bound and relative_displacement_bound of the answer; no bound of the forces is needed. If middle_factor is
  !> empty, nothing changes. The error of the forces is at most |delta|_{W^-1}, where delta are the errors of the interpolated
  !> openings. delta is the sum of rho, which are the openings by modes less the interpolated ones, and of the errors of the
  !> openings by modes. The norm of these errors is at most that of the residual r. So |u_r - u|_K <= 2 |r|_{K^-1} + |rho|_{W^-1},
  !> to which rounding is added. In it W >= W(mu_0) / b, where b is the largest K / K(mu_0) of the bodies. Requires: solve_modes
  !> gave room%residual and room%field_size.
  subroutine bound_displacement(self, room, answer)
    class(reduced_interpolated_t), intent(in) :: self
    type(interpolated_room_t), intent(in) :: room
    type(answer_t), intent(inout) :: answer
    real(rk) :: closing(self%n_rows()), forces(self%n_rows()), missing(self%n_rows()), rho(self%n_rows()), size_of_field, stiffest

    if (.not. allocated(self%middle_factor)) return
    if (size(self%middle_factor) == 0) return
    call close_by_modes(self, answer%theta, answer%coordinates, closing, stiffest)
    forces = answer%unknowns
    forces(self%anchors) = 0
    ! D - B u_r - (W lambda_r + q)
    missing = -room%free_opening - closing
    call multiply(-1.0_rk, room%compliance, forces, 1.0_rk, missing)
    call multiply(1.0_rk, self%gap, answer%theta, 1.0_rk, missing)
    rho(:size(self%free_rows)) = missing(self%free_rows)
    call reduce_cholesky(size(self%free_rows), self%middle_factor, rho)
    size_of_field = comparable_size(room%field_size, self%largest_field)
    call answer%take_displacement_bound(2 * room%residual + sqrt(stiffest) * norm2(rho(:size(self%free_rows))) + &
      self%rounding() * size_of_field, size_of_field)
  end subroutine bound_displacement

  !> Computes the displacement [length] of all dofs, shape (n_dofs); it is NaN for dofs of which this part has none.
  subroutine fill_displacement(self, answer, displacement)
    class(reduced_interpolated_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    real(rk), contiguous, intent(inout) :: displacement(:)

    call fill_interpolated_displacement(self, answer%theta, answer%unknowns, answer%coordinates, displacement)
  end subroutine fill_displacement

  !> Returns the displacement [length] of one dof, 1-based; NaN if this part has none of this dof.
  pure real(rk) function displacement_of_dof(self, answer, dof) result(displacement)
    class(reduced_interpolated_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    integer, intent(in) :: dof

    displacement = interpolated_displacement_of_dof(self, answer%theta, answer%unknowns, answer%coordinates, dof)
  end function displacement_of_dof

  !> Returns the number of modes of all bodies, which give displacements; forces do not depend on them.
  pure integer function n_modes(self)
    class(reduced_interpolated_t), intent(in) :: self

    n_modes = n_modes_of(self)
  end function n_modes

  !> Returns the rounding error [-] that bounds allow for, relative to the size of the answer: least_rounding (1e-10). If the
  !> responses of all bodies are exact, the error that was measured at the training points is rounding, too, and the larger number
  !> counts: a body that few contacts hold loses digits.
  pure real(rk) function rounding(self)
    class(reduced_interpolated_t), intent(in) :: self
    integer :: i

    rounding = least_rounding
    do i = 1, size(self%bodies)
      if (size(self%bodies(i)%numerators) > 0) return
    end do
    rounding = max(rounding, self%measured_error)
  end function rounding

  !> Whether the responses of each body are exact or have a bound of their interpolation error.
  pure logical function can_certify(self)
    class(reduced_interpolated_t), intent(in) :: self

    can_certify = self%has_bound()
  end function can_certify

  !> Bounds the error of forces. For the part's own forces it is the error of the interpolation, as the interpolated problem itself
  !> was solved except for rounding. For own forces the displacement is bounded, too: with u(lambda_r), the
  !> displacement under these forces, |u_r - u|_K <= |u_r - u(lambda_r)|_K + |u(lambda_r) - u|_K, where the last term equals the
  !> error of the forces, |lambda_r - lambda|_W. Without modes the first term is the error of the
  !> interpolation (field_bound). Forces that another part found get no bound if there are anchors. Arguments: no_certificate in
  !> sig_reduced. Requires: can_certify; for own forces, that solve with this room found them last.
  subroutine certify(self, multipliers, is_own, room, answer)
    class(reduced_interpolated_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: multipliers(:)
    logical, intent(in) :: is_own
    class(room_t), intent(inout) :: room
    type(answer_t), intent(inout) :: answer
    real(rk) :: bound, size_of_answer

    if (.not. is_own) then
      call certify_foreign(self, multipliers, room, answer)
      return
    end if
    size_of_answer = comparable_size(self%size_in_energy(room, multipliers), self%largest_size)
    bound = self%bound(answer%theta, answer%unknowns) + self%rounding() * size_of_answer
    call answer%take_bound(bound, size_of_answer)
    if (.not. self%has_modes()) then
      if (.not. self%has_displacement()) return
      bound = bound + self%field_bound(answer%theta, answer%unknowns)
      size_of_answer = comparable_size(self%size_of_field(answer%theta, answer%unknowns, &
        self%size_in_energy(room, multipliers)**2), self%largest_field)
      call answer%take_displacement_bound(bound + self%rounding() * size_of_answer, size_of_answer)
      return
    end if
    select type (room)
    type is (interpolated_room_t)
      size_of_answer = comparable_size(room%field_size, self%largest_field)
      call answer%take_displacement_bound(bound + room%residual + self%rounding() * size_of_answer, size_of_answer)
    end select
  end subroutine certify

  !> Sets bound and relative_bound of the answer for forces that another part found (bound_foreign_forces); with anchors nothing
  !> changes. Arguments: no_certificate in sig_reduced. Requires: can_certify.
  subroutine certify_foreign(self, multipliers, room, answer)
    type(reduced_interpolated_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: multipliers(:)
    class(room_t), intent(inout) :: room
    type(answer_t), intent(inout) :: answer
    real(rk) :: size_of_answer

    if (size(self%anchors) > 0) return
    select type (room)
    type is (interpolated_room_t)
      call self%evaluate(answer%theta, room%compliance, room%opening)
      call multiply(1.0_rk, room%compliance, multipliers, 1.0_rk, room%opening)
      size_of_answer = comparable_size(self%size_in_energy(room, multipliers), self%largest_size)
      call answer%take_bound(bound_foreign_forces(self, answer%theta, multipliers, room%compliance, room%opening, &
        self%rounding() * size_of_answer), size_of_answer)
    end select
  end subroutine certify_foreign

  !> Returns the energy E = 1/2 lambda' W lambda + q' lambda [force*length] of forces of all contacts, without the rows of anchors
  !> (interpolated_energy); huge for forces that do not balance the loads on bodies that only contact holds. Arguments:
  !> energy_unknown in sig_reduced. Requires: prepare.
  real(rk) function energy(self, theta, multipliers, opening)
    class(reduced_interpolated_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    real(rk), contiguous, intent(in) :: multipliers(:)
    real(rk), contiguous, intent(inout) :: opening(:)

    energy = interpolated_energy(self, theta, multipliers, opening)
  end function energy

  !> Returns the size sqrt(lambda' W lambda) [sqrt(force*length)] of forces, with closed anchors: forces on anchors do not count. W
  !> is the one that solve, or certify for forces of another part, left in the room.
  real(rk) function size_in_energy(self, room, multipliers) result(size_of_forces)
    class(reduced_interpolated_t), intent(in) :: self
    class(room_t), intent(in) :: room
    !> [force] of all contacts, shape (n_multipliers)
    real(rk), intent(in) :: multipliers(:)
    real(rk) :: forces(size(multipliers)), closing(size(multipliers))

    size_of_forces = 0
    forces = multipliers
    forces(self%anchors) = 0
    select type (room)
    type is (interpolated_room_t)
      call multiply(1.0_rk, room%compliance, forces, 0.0_rk, closing)
      size_of_forces = sqrt(max(0.0_rk, dot_product(forces, closing)))
    end select
  end function size_in_energy

  !> Returns lines about forces, bodies and displacements of the part, each with its line end.
  pure function describe(self) result(text)
    class(reduced_interpolated_t), intent(in) :: self
    character(:), allocatable :: text
    integer :: i

    text = line('  forces', 'on all ' // counted(self%n_rows(), 'contact row') // '; largest error at the training points ' // &
      short_number(self%measured_error) // trim(merge('                                                ', &
      ', an estimate for others: answers have no bound ', self%has_bound())))
    do i = 1, size(self%bodies)
      associate (body => self%bodies(i))
        if (size(body%numerators) == 0) then
          text = text // line('  body ' // to_text(i), 'exact: all its moduli scale together')
        else
          text = text // line('  body ' // to_text(i), 'interpolated over ' // &
            counted(size(body%numerators), 'elastic constant') // ', ' // counted(body%nodes%n_nodes(), 'node'))
        end if
      end associate
    end do
    text = text // line('  displacements', &
      displacement_text(self%exact_boundaries, size(self%exact_dofs), modes_text(self%n_modes())))
  end function describe

  !> Computes the derivatives of the answer with respect to each parameter (differentiate_interpolated). Errors: message is
  !> allocated if the contact forces are not unique, the loads move a body that no contact force holds, or the problem of the
  !> contacts that graze has no solution. Arguments: no_derivative in sig_reduced.
  subroutine differentiate(self, answer, gradient, message)
    class(reduced_interpolated_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    type(gradient_t), intent(inout) :: gradient
    character(:), allocatable, intent(out) :: message
    logical :: is_pushed, is_singular

    call differentiate_interpolated(self, answer%theta, answer%unknowns, answer%coordinates, answer%multipliers, gradient, &
      is_singular, is_pushed)
    if (is_pushed) then
      message = pushed
    else if (is_singular) then
      message = not_unique
    end if
  end subroutine differentiate

  !> Computes the derivatives of the displacement of the given dofs with respect to one parameter; NaN for dofs of which this part
  !> has no displacement, and for those that move in a motion that no contact force holds. Arguments: no_changes in sig_reduced.
  subroutine displacement_changes(self, answer, gradient, i_parameter, dofs, changes)
    class(reduced_interpolated_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    type(gradient_t), intent(in) :: gradient
    integer, intent(in) :: i_parameter
    integer, intent(in) :: dofs(:)
    real(rk), intent(out) :: changes(:)
    integer :: i, places(size(dofs))
    logical :: is_loose
    real(rk), allocatable :: found(:)

    places = [(place_in_ascending(self%exact_dofs, dofs(i)), i=1, size(dofs))]
    allocate (found(count(places > 0)))
    call interpolated_displacement_changes(self, answer%theta, answer%unknowns, gradient, i_parameter, &
      pack(places, places > 0), found)
    changes = unpack(found, places > 0, ieee_value(1.0_rk, ieee_quiet_nan))
    do i = 1, size(dofs)
      if (places(i) > 0) then
        is_loose = gradient%is_loose(i_parameter, self%anchor_motions(places(i), :))
      else if (self%has_modes()) then
        changes(i) = mode_displacement_change(self, gradient, i_parameter, dofs(i))
        is_loose = gradient%is_loose(i_parameter, self%mode_motions(dofs(i), :))
      else
        cycle
      end if
      if (is_loose) changes(i) = ieee_value(1.0_rk, ieee_quiet_nan)
    end do
  end subroutine displacement_changes
end module sig_reduced_interpolated
