! SPDX-License-Identifier: BSD-3-Clause
!> W and q as sums over bodies whose elastic constants depend on the parameters, interpolated over these constants; and the
!> displacement: interpolated at the exact dofs, by modes at the others, or none.
module sig_body_compliance
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use sig_answer, only: answer_t, comparable_size, no_bound
  use sig_body_data, only: body_data_t
  use sig_body_response, only: body_weights_t
  use sig_compliance, only: compliance_point_t, round_work
  use sig_dense_kernels, only: factor_cholesky, reduce_cholesky
  use sig_description_line, only: line, modes_text
  use sig_gradient, only: gradient_t
  use sig_kinds, only: rk
  use sig_linear_algebra, only: multiply
  use sig_shape_checks, only: place_in_ascending
  use sig_text, only: counted, short_number, to_text
  implicit none(type, external)
  private
  public :: body_compliance_t

  type, extends(body_data_t) :: body_compliance_t
    !> L of W = L L' at mu_0 without the anchors; empty where W is not needed
    real(rk), allocatable, private :: middle_factor(:, :)
    !> rows that are not anchors
    integer, allocatable, private :: free_rows(:)
  contains
    procedure :: kind => kind_of
    procedure :: describe
    procedure :: describe_bodies
    procedure :: is_fixed
    procedure :: prepare
    procedure :: create_point
    procedure :: evaluate
    procedure :: matrix
    procedure :: change_openings
    procedure :: fill_displacement
    procedure :: displacement_of_dof
    procedure :: complete_gradient
    procedure :: change_field
    procedure :: anchor_motion
    procedure :: n_modes
    procedure :: solve_modes
    procedure :: size_of_field
    procedure :: driven_size
    procedure :: field_error
    procedure :: has_linear_field
    procedure :: bound_change
    procedure :: own_error
    procedure :: foreign_factor
    procedure :: rounding
  end type body_compliance_t

  !> [-] smallest rounding error of the factorizations, relative to the size of the answer
  real(rk), parameter :: least_rounding = 1.0e-10_rk

contains

  pure function kind_of(self) result(text)
    class(body_compliance_t), intent(in) :: self
    character(:), allocatable :: text

    text = 'interpolated'
  end function kind_of

  pure function describe(self) result(text)
    class(body_compliance_t), intent(in) :: self
    character(:), allocatable :: text

    text = line('  forces', 'on all ' // counted(self%n_rows(), 'contact row') // '; largest error at the training points ' // &
      short_number(self%measured_error) // trim(merge('                                                ', &
      ', an estimate for others: answers have no bound ', self%has_bound())))
    text = text // self%describe_bodies() // line('  displacements', self%displacement_text(modes_text(self%n_modes())))
  end function describe

  !> Returns a line for each body: how its responses depend on its elastic constants.
  pure function describe_bodies(self) result(text)
    class(body_compliance_t), intent(in) :: self
    character(:), allocatable :: text
    integer :: i

    text = ''
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
  end function describe_bodies

  pure logical function is_fixed(self)
    class(body_compliance_t), intent(in) :: self

    is_fixed = .false.
  end function is_fixed

  !> Prepares the polynomials of the interpolations. If the data have W at mu_0 (middle_compliance), it is factored without the
  !> anchors for bound_by_modes, which gives no bound if this W is not positive definite.
  subroutine prepare(self)
    class(body_compliance_t), intent(inout) :: self
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

  pure subroutine create_point(self, point)
    class(body_compliance_t), intent(in) :: self
    type(compliance_point_t), intent(out) :: point

    allocate (point%opening(self%n_rows()), point%matrix(self%n_rows(), self%n_rows()), point%rows(0))
  end subroutine create_point

  subroutine evaluate(self, theta, point, is_valid)
    class(body_compliance_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    type(compliance_point_t), intent(inout) :: point
    logical, intent(out) :: is_valid

    is_valid = self%has_material(theta)
    if (is_valid) call self%add_up(theta, point%matrix, point%opening)
  end subroutine evaluate

  function matrix(self, point)
    class(body_compliance_t), target, intent(in) :: self
    type(compliance_point_t), target, intent(in) :: point
    real(rk), pointer, contiguous :: matrix(:, :)

    matrix => point%matrix
  end function matrix

  !> Computes the coordinates of the modes of all bodies under loads and contact forces, a bound of the residual of equilibrium, and
  !> the size of the displacement. The coordinates of a body are zero if its reduced stiffness is not positive definite. Then it
  !> bounds the error of the displacement (bound_by_modes). Without modes it does nothing.
  subroutine solve_modes(self, point, answer)
    class(body_compliance_t), intent(in) :: self
    type(compliance_point_t), intent(inout) :: point
    type(answer_t), intent(inout) :: answer
    real(rk) :: own_energy, own_residual
    integer :: first, i, last

    if (.not. self%has_modes()) return
    point%residual = 0
    point%field_size = 0
    last = 0
    do i = 1, size(self%modes)
      first = last + 1
      last = last + self%modes(i)%n_modes()
      call self%modes(i)%solve(answer%theta, self%with_closed_anchors(answer%unknowns), answer%coordinates(first:last), &
        own_residual, own_energy)
      point%residual = point%residual + own_residual**2
      point%field_size = point%field_size + own_energy
    end do
    point%residual = sqrt(point%residual)
    point%field_size = sqrt(point%field_size)
    call bound_by_modes(self, point, answer)
  end subroutine solve_modes

  !> Sets displacement_bound and relative_displacement_bound of the answer; no bound of the forces is needed. If middle_factor is
  !> empty, nothing changes. The error of the forces is at most |delta|_{W^-1}, where delta are the errors of the interpolated
  !> openings. delta is the sum of rho, which are the openings by modes less the interpolated ones, and of the errors of the
  !> openings by modes. The norm of these errors is at most that of the residual r. So |u_r - u|_K <= 2 |r|_{K^-1} + |rho|_{W^-1},
  !> to which rounding is added. In it W >= W(mu_0) / b, where b is the largest K / K(mu_0) of the bodies.
  subroutine bound_by_modes(self, point, answer)
    type(body_compliance_t), intent(in) :: self
    type(compliance_point_t), intent(in) :: point
    !> in: with the coordinates of the modes
    type(answer_t), intent(inout) :: answer
    real(rk) :: closing(self%n_rows()), missing(self%n_rows()), rho(self%n_rows()), size_of_field

    if (.not. allocated(self%middle_factor)) return
    if (size(self%middle_factor) == 0) return
    call close_by_modes(self, answer%theta, answer%coordinates, closing)
    ! D - B u_r - (W lambda_r + q)
    missing = -point%opening - closing
    call multiply(-1.0_rk, point%matrix, self%with_closed_anchors(answer%unknowns), 1.0_rk, missing)
    call multiply(1.0_rk, self%gap, answer%theta, 1.0_rk, missing)
    rho(:size(self%free_rows)) = missing(self%free_rows)
    call reduce_cholesky(size(self%free_rows), self%middle_factor, rho)
    size_of_field = comparable_size(point%field_size, self%largest_field)
    call answer%take_displacement_bound(2 * point%residual + sqrt(stiffest_part(self, answer%theta)) * &
      norm2(rho(:size(self%free_rows))) + self%rounding() * size_of_field, size_of_field)
  end subroutine bound_by_modes

  !> Computes B u_r, by which all contacts close. u_r is the displacement by modes; the rigid motions of bodies that only contact
  !> holds are left out. It is linear in the terms and in the coordinates.
  subroutine close_by_modes(self, theta, coordinates, closing)
    type(body_compliance_t), intent(in) :: self
    !> shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    !> [length] coordinates from solve_modes
    real(rk), contiguous, intent(in) :: coordinates(:)
    !> [length] shape (n_multipliers)
    real(rk), contiguous, intent(inout) :: closing(:)
    integer :: first, i, last

    closing = 0
    last = 0
    do i = 1, size(self%modes)
      first = last + 1
      last = last + self%modes(i)%n_modes()
      call self%modes(i)%add_closing(theta, coordinates(first:last), closing)
    end do
  end subroutine close_by_modes

  !> Returns a factor b [-] with K <= b K(mu_0) for all bodies; K(mu_0) is the stiffness for the moduli for which the modes were
  !> made.
  pure real(rk) function stiffest_part(self, theta)
    type(body_compliance_t), intent(in) :: self
    !> shape (n_terms)
    real(rk), intent(in) :: theta(:)
    integer :: i

    stiffest_part = 0
    do i = 1, size(self%modes)
      stiffest_part = max(stiffest_part, self%modes(i)%stiffest(theta))
    end do
  end function stiffest_part

  !> Returns the number of modes of all bodies together, which give displacements; forces do not depend on them.
  pure integer function n_modes(self)
    class(body_compliance_t), intent(in) :: self
    integer :: i

    n_modes = 0
    if (allocated(self%modes)) n_modes = sum([(self%modes(i)%n_modes(), i=1, size(self%modes))])
  end function n_modes

  subroutine fill_displacement(self, answer, displacement)
    class(body_compliance_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    real(rk), contiguous, intent(inout) :: displacement(:)
    real(rk) :: exact(size(self%exact_dofs)), moves(size(self%anchors))
    integer :: first, i, last

    displacement = ieee_value(1.0_rk, ieee_quiet_nan)
    moves = anchor_moves(self, answer%theta, answer%unknowns, answer%theta)
    last = 0
    do i = 1, size(self%modes)
      first = last + 1
      last = last + self%modes(i)%n_modes()
      call self%modes(i)%add_field(answer%theta, answer%coordinates(first:last), displacement)
    end do
    if (size(self%modes) > 0 .and. size(moves) > 0) call multiply(1.0_rk, self%mode_motions, moves, 1.0_rk, displacement)
    call fill_exact(self, answer%theta, self%with_closed_anchors(answer%unknowns), exact)
    if (size(moves) > 0) call multiply(1.0_rk, self%anchor_motions, moves, 1.0_rk, exact)
    displacement(self%exact_dofs) = exact
  end subroutine fill_displacement

  !> Computes the displacement of the exact dofs, in the order of exact_dofs, without the rigid motions of the anchors.
  subroutine fill_exact(self, theta, forces, displacement)
    type(body_compliance_t), intent(in) :: self
    !> shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    !> [force] z, zero on anchors; shape (n_multipliers)
    real(rk), contiguous, intent(in) :: forces(:)
    !> [length] shape (n_exact)
    real(rk), contiguous, intent(inout) :: displacement(:)
    real(rk), allocatable :: own(:)
    integer :: i

    displacement = 0
    do i = 1, size(self%bodies)
      allocate (own(size(self%bodies(i)%own)), source=0.0_rk)
      call self%bodies(i)%add_field(self%bodies(i)%weights_at(theta), theta, forces, own)
      displacement(self%bodies(i)%own) = own
      deallocate (own)
    end do
  end subroutine fill_exact

  pure real(rk) function displacement_of_dof(self, answer, dof) result(displacement)
    class(body_compliance_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    integer, intent(in) :: dof
    integer :: i, i_body, i_own

    i = place_in_ascending(self%exact_dofs, dof)
    if (i > 0) then
      displacement = dot_product(self%anchor_motions(i, :), anchor_moves(self, answer%theta, answer%unknowns, answer%theta))
      do i_body = 1, size(self%bodies)
        i_own = place_in_ascending(self%bodies(i_body)%own, i)
        if (i_own > 0) displacement = displacement + self%bodies(i_body)%displacement_of( &
          self%bodies(i_body)%weights_at(answer%theta), answer%theta, self%with_closed_anchors(answer%unknowns), i_own)
      end do
    else if (size(self%modes) > 0) then
      displacement = dot_product(self%mode_motions(dof, :), anchor_moves(self, answer%theta, answer%unknowns, answer%theta)) + &
        value_by_modes(self, answer%theta, answer%coordinates, dof)
    else
      displacement = ieee_value(1.0_rk, ieee_quiet_nan)
    end if
  end function displacement_of_dof

  !> Returns the displacement [length] of one dof by modes, without the rigid motions of the anchors. It is linear in the terms and
  !> in the coordinates, so that their changes give its change.
  pure real(rk) function value_by_modes(self, theta, coordinates, dof) result(displacement)
    class(body_compliance_t), intent(in) :: self
    real(rk), intent(in) :: theta(:)
    !> [length] of the modes of all bodies
    real(rk), intent(in) :: coordinates(:)
    !> 1-based
    integer, intent(in) :: dof
    integer :: first, i, last

    displacement = 0
    last = 0
    do i = 1, size(self%modes)
      first = last + 1
      last = last + self%modes(i)%n_modes()
      displacement = displacement + self%modes(i)%displacement_of(theta, coordinates(first:last), dof)
    end do
  end function value_by_modes

  !> Returns the distance [length] by which rigid motions of the bodies close each anchor, shape (n_anchors). It is linear in theta
  !> and unknowns.
  pure function anchor_moves(self, theta, unknowns, at) result(moves)
    class(body_compliance_t), intent(in) :: self
    !> shape (n_terms)
    real(rk), intent(in) :: theta(:)
    !> [force] z, shape (n_multipliers)
    real(rk), intent(in) :: unknowns(:)
    !> values of the terms for the elastic constants, shape (n_terms)
    real(rk), intent(in) :: at(:)
    real(rk) :: moves(size(self%anchors))
    real(rk) :: forces(size(unknowns))
    type(body_weights_t) :: weights
    integer :: i, i_body

    forces = self%with_closed_anchors(unknowns)
    do i = 1, size(self%anchors)
      moves(i) = dot_product(self%gap(self%anchors(i), :), theta) - self%scale * unknowns(self%anchors(i))
    end do
    do i_body = 1, merge(size(self%bodies), 0, size(moves) > 0)
      weights = self%bodies(i_body)%weights_at(at)
      do i = 1, size(moves)
        moves(i) = moves(i) + self%bodies(i_body)%opening_of_row(weights, theta, forces, self%anchors(i))
      end do
    end do
  end function anchor_moves

  pure function anchor_motion(self, dof) result(motion)
    class(body_compliance_t), intent(in) :: self
    integer, intent(in) :: dof
    real(rk), allocatable :: motion(:)
    integer :: i

    allocate (motion(size(self%anchors)), source=0.0_rk)
    i = place_in_ascending(self%exact_dofs, dof)
    if (i > 0) then
      motion = self%anchor_motions(i, :)
    else if (self%has_modes()) then
      motion = self%mode_motions(dof, :)
    end if
  end function anchor_motion

  !> By the product rule for W(mu) and q(mu): the bodies' responses change with their elastic constants.
  subroutine change_openings(self, point, theta, theta_change, unknowns, changes)
    class(body_compliance_t), intent(in) :: self
    type(compliance_point_t), intent(in) :: point
    real(rk), contiguous, intent(in) :: theta(:)
    real(rk), contiguous, intent(in) :: theta_change(:)
    !> values on anchors do not count, because their columns of W do not change
    real(rk), contiguous, intent(in) :: unknowns(:)
    real(rk), contiguous, intent(inout) :: changes(:)
    type(body_weights_t) :: weight_changes
    integer :: i

    call multiply(1.0_rk, self%gap, theta_change, 0.0_rk, changes)
    do i = 1, size(self%bodies)
      weight_changes = self%bodies(i)%change_weights(theta, theta_change)
      call self%bodies(i)%add_closing(weight_changes, self%with_closed_anchors(unknowns), changes)
      call self%bodies(i)%add_opening(weight_changes, theta, changes)
      call self%bodies(i)%add_opening(self%bodies(i)%weights_at(theta), theta_change, changes)
    end do
    changes(self%anchors) = self%scale * matmul(self%anchor_forces, theta_change)
    call round_work(self%anchors, self%scale * matmul(abs(self%anchor_forces), abs(theta_change)), changes)
  end subroutine change_openings

  !> Adds the derivatives of the moves of the anchors (anchor_moves) and of the coordinates of the modes.
  subroutine complete_gradient(self, answer, gradient)
    class(body_compliance_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    type(gradient_t), intent(inout) :: gradient
    integer :: i

    if (allocated(gradient%moves)) deallocate (gradient%moves)
    if (allocated(gradient%coordinates)) deallocate (gradient%coordinates)
    associate (n_parameters => size(gradient%theta, 2))
      allocate (gradient%moves(size(self%anchors), n_parameters), gradient%coordinates(size(answer%coordinates), n_parameters))
      do i = 1, n_parameters
        gradient%moves(:, i) = move_changes(self, answer, gradient%theta(:, i), gradient%unknowns(:, i))
        call change_modes(self, answer, gradient%theta(:, i), self%with_closed_anchors(gradient%unknowns(:, i)), &
          gradient%coordinates(:, i))
      end do
    end associate
  end subroutine complete_gradient

  !> Computes the changes of the mode coordinates of all bodies, one body after the other, for given changes of terms and forces.
  subroutine change_modes(self, answer, theta_change, force_change, changes)
    type(body_compliance_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    !> shape (n_terms)
    real(rk), contiguous, intent(in) :: theta_change(:)
    !> [force] change of z, zero on anchors; shape (n_multipliers)
    real(rk), contiguous, intent(in) :: force_change(:)
    !> [length] shape (n_modes)
    real(rk), intent(out) :: changes(:)
    integer :: first, i, last

    last = 0
    do i = 1, size(self%modes)
      first = last + 1
      last = last + self%modes(i)%n_modes()
      call self%modes(i)%change(answer%theta, theta_change, answer%coordinates(first:last), force_change, changes(first:last))
    end do
  end subroutine change_modes

  !> Returns the changes [length] of how far each anchor closes (anchor_moves).
  function move_changes(self, answer, theta_change, unknown_change) result(changes)
    type(body_compliance_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    !> shape (n_terms)
    real(rk), contiguous, intent(in) :: theta_change(:)
    !> [force] change of z, shape (n_multipliers)
    real(rk), intent(in) :: unknown_change(:)
    real(rk) :: changes(size(self%anchors))
    real(rk) :: forces(size(unknown_change))
    type(body_weights_t) :: weight_changes
    integer :: i, i_body

    forces = self%with_closed_anchors(answer%unknowns)
    changes = anchor_moves(self, theta_change, unknown_change, answer%theta)
    do i_body = 1, merge(size(self%bodies), 0, size(changes) > 0)
      weight_changes = self%bodies(i_body)%change_weights(answer%theta, theta_change)
      do i = 1, size(changes)
        changes(i) = changes(i) + self%bodies(i_body)%opening_of_row(weight_changes, answer%theta, forces, self%anchors(i))
      end do
    end do
  end function move_changes

  subroutine change_field(self, answer, gradient, i_parameter, dofs, changes)
    class(body_compliance_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    type(gradient_t), intent(in) :: gradient
    integer, intent(in) :: i_parameter
    integer, intent(in) :: dofs(:)
    real(rk), intent(out) :: changes(:)
    integer :: i, places(size(dofs))
    real(rk), allocatable :: found(:)

    places = [(place_in_ascending(self%exact_dofs, dofs(i)), i=1, size(dofs))]
    found = exact_changes(self, answer, gradient, i_parameter, pack(places, places > 0))
    changes = unpack(found, places > 0, ieee_value(1.0_rk, ieee_quiet_nan))
    if (.not. self%has_modes()) return
    do i = 1, size(dofs)
      if (places(i) == 0) changes(i) = dot_product(self%mode_motions(dofs(i), :), gradient%moves(:, i_parameter)) + &
        value_by_modes(self, gradient%theta(:, i_parameter), gradient%coordinates(:, i_parameter), dofs(i))
    end do
  end subroutine change_field

  !> Returns the derivatives [length per unit of the parameter] of the displacement of some exact dofs with respect to one
  !> parameter.
  function exact_changes(self, answer, gradient, i_parameter, places) result(changes)
    type(body_compliance_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    type(gradient_t), intent(in) :: gradient
    integer, intent(in) :: i_parameter
    !> places among the exact dofs, 1-based
    integer, intent(in) :: places(:)
    real(rk) :: changes(size(places))
    real(rk) :: forces(size(answer%unknowns)), force_change(size(answer%unknowns))
    type(body_weights_t) :: weight_changes, weights
    integer :: i, i_body, i_own

    forces = self%with_closed_anchors(answer%unknowns)
    force_change = self%with_closed_anchors(gradient%unknowns(:, i_parameter))
    changes = matmul(self%anchor_motions(places, :), gradient%moves(:, i_parameter))
    do i_body = 1, size(self%bodies)
      associate (body => self%bodies(i_body))
        weights = body%weights_at(answer%theta)
        weight_changes = body%change_weights(answer%theta, gradient%theta(:, i_parameter))
        do i = 1, size(places)
          i_own = place_in_ascending(body%own, places(i))
          if (i_own > 0) changes(i) = changes(i) + body%displacement_of(weight_changes, answer%theta, forces, i_own) + &
            body%displacement_of(weights, gradient%theta(:, i_parameter), force_change, i_own)
        end do
      end associate
    end do
  end function exact_changes

  !> Returns |u|_K. By modes it is that of their displacement; otherwise driven_size.
  real(rk) function size_of_field(self, theta, unknowns, energy, point) result(size_of)
    class(body_compliance_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    real(rk), contiguous, intent(in) :: unknowns(:)
    real(rk), intent(in) :: energy
    type(compliance_point_t), intent(in) :: point

    size_of = point%field_size
    if (.not. self%has_modes()) size_of = self%driven_size(theta, unknowns, energy)
  end function size_of_field

  !> Returns the size |u|_K [sqrt(force*length)] of the true displacement: driven_energy of sig_body_response has the parts that
  !> depend on the driving terms.
  real(rk) function driven_size(self, theta, unknowns, energy) result(size_of)
    class(body_compliance_t), intent(in) :: self
    !> shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    !> [force] z, shape (n_multipliers); values on anchors do not count
    real(rk), contiguous, intent(in) :: unknowns(:)
    !> [force*length] z'W z with closed anchors
    real(rk), intent(in) :: energy
    integer :: i

    size_of = energy
    do i = 1, size(self%bodies)
      size_of = size_of + self%bodies(i)%driven_energy(theta, self%with_closed_anchors(unknowns))
    end do
    size_of = sqrt(max(0.0_rk, size_of))
  end function driven_size

  !> By modes it is the residual of equilibrium, otherwise the error that interpolation makes in the displacement of the exact dofs;
  !> bodies share no dofs. Requires: has_bound.
  real(rk) function field_error(self, theta, unknowns, energy, point)
    class(body_compliance_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    real(rk), contiguous, intent(in) :: unknowns(:)
    real(rk), intent(in) :: energy
    type(compliance_point_t), intent(in) :: point
    real(rk) :: bounds(size(self%bodies))
    integer :: i

    field_error = point%residual
    if (self%has_modes()) return
    do i = 1, size(bounds)
      bounds(i) = self%bodies(i)%field_bound(theta, self%with_closed_anchors(unknowns))
    end do
    field_error = norm2(bounds)
  end function field_error

  !> Returns false: responses change with the elastic constants.
  pure logical function has_linear_field(self)
    class(body_compliance_t), intent(in) :: self

    has_linear_field = .false.
  end function has_linear_field

  !> Bounds the error of the displacement's derivative, by the README of this folder:
  !>
  !>     |e'|_K <= |r'|_{K^-1} + kappa |e|_K + |rho'|_{W^-1},   |K'e|_{K^-1} <= kappa |e|_K,
  !>
  !> with the largest relative change kappa of a part of the stiffness, and |e|_K from displacement_bound; rho are the openings that
  !> the displacement misses (bound_by_modes). An interpolated displacement has rho = 0. With modes, if the forces have a bound,
  !> |rho'|_{W^-1} <= |r_I'|_{K^-1} + kappa |r_I|_{K^-1} with the residual r_I of the interpolated displacement under the same
  !> forces. Not known where displacement_bound is not.
  subroutine bound_change(self, answer, gradient, i_parameter, point, bound, size_of_change)
    class(body_compliance_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    type(gradient_t), intent(in) :: gradient
    integer, intent(in) :: i_parameter
    type(compliance_point_t), intent(in) :: point
    real(rk), intent(out) :: bound
    real(rk), intent(out) :: size_of_change
    real(rk) :: closed(self%n_rows()), closed_change(self%n_rows())
    real(rk) :: errors(size(self%bodies)), missing(size(self%bodies)), rate, residual, sizes(size(self%bodies))
    integer :: i

    bound = no_bound
    size_of_change = 0
    if (.not. answer%displacement_bound >= 0) return
    closed = self%with_closed_anchors(answer%unknowns)
    closed_change = self%with_closed_anchors(gradient%unknowns(:, i_parameter))
    associate (theta => answer%theta, theta_change => gradient%theta(:, i_parameter))
      missing = 0
      if (self%has_bound()) then
        do i = 1, size(self%bodies)
          errors(i) = self%bodies(i)%field_bound(theta, closed)
          missing(i) = self%bodies(i)%field_change_bound(theta, theta_change, closed, closed_change)
        end do
      end if
      if (self%has_modes()) then
        call measure_modes(self, answer, gradient, i_parameter, residual, size_of_change, rate)
        if (self%has_bound()) then
          bound = residual + norm2(missing) + rate * (answer%displacement_bound + norm2(errors))
        else
          bound = residual + rate * answer%displacement_bound + missed_change(self, answer, gradient, i_parameter, point)
        end if
      else
        rate = maxval([(self%bodies(i)%stiffness_rate(theta, theta_change), i=1, size(self%bodies))])
        bound = norm2(missing) + rate * answer%displacement_bound
        do i = 1, size(sizes)
          sizes(i) = self%bodies(i)%field_change_size(theta, theta_change, closed, closed_change)
        end do
        size_of_change = norm2(sizes)
      end if
    end associate
  end subroutine bound_change

  !> Computes the residual and the size of the derivative of the displacement by modes [sqrt(force*length) per unit of the
  !> parameter], and the largest relative change of a part of the stiffness [per unit of the parameter].
  subroutine measure_modes(self, answer, gradient, i_parameter, residual, size_of_change, rate)
    type(body_compliance_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    type(gradient_t), intent(in) :: gradient
    integer, intent(in) :: i_parameter
    real(rk), intent(out) :: residual
    real(rk), intent(out) :: size_of_change
    real(rk), intent(out) :: rate
    real(rk) :: closed_change(self%n_rows()), energies(size(self%modes)), residuals(size(self%modes))
    integer :: first, i, last

    closed_change = self%with_closed_anchors(gradient%unknowns(:, i_parameter))
    rate = 0
    last = 0
    do i = 1, size(self%modes)
      first = last + 1
      last = last + self%modes(i)%n_modes()
      call self%modes(i)%measure_change(answer%theta, gradient%theta(:, i_parameter), answer%coordinates(first:last), &
        closed_change, gradient%coordinates(first:last, i_parameter), residuals(i), energies(i))
      rate = max(rate, self%modes(i)%stiffness_rate(answer%theta, gradient%theta(:, i_parameter)))
    end do
    residual = norm2(residuals)
    size_of_change = sqrt(sum(energies))
  end subroutine measure_modes

  !> Returns an upper bound [sqrt(force*length) per unit of the parameter] of |rho'|_{W^-1}: rho is that of bound_by_modes.
  real(rk) function missed_change(self, answer, gradient, i_parameter, point) result(missed)
    type(body_compliance_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    type(gradient_t), intent(in) :: gradient
    integer, intent(in) :: i_parameter
    !> after evaluate
    type(compliance_point_t), intent(in) :: point
    real(rk), dimension(self%n_rows()) :: changes, closing, rho

    associate (theta_change => gradient%theta(:, i_parameter), n => size(self%free_rows))
      call close_by_modes(self, theta_change, gradient%coordinates(:, i_parameter), closing)
      call self%change_openings(point, answer%theta, theta_change, answer%unknowns, changes)
      changes = -changes - closing
      call multiply(-1.0_rk, point%matrix, self%with_closed_anchors(gradient%unknowns(:, i_parameter)), 1.0_rk, changes)
      call multiply(1.0_rk, self%gap, theta_change, 1.0_rk, changes)
      rho(:n) = changes(self%free_rows)
      call reduce_cholesky(n, self%middle_factor, rho)
      missed = sqrt(stiffest_part(self, answer%theta)) * norm2(rho(:n))
    end associate
  end function missed_change

  !> Returns a bound [sqrt(force*length)] of |lambda_r - lambda| in the norm of W, for the forces of the interpolated problem. For
  !> other forces it bounds only the part of the error that interpolation makes. Source: README. Requires: has_bound.
  real(rk) function own_error(self, theta, unknowns) result(bound)
    class(body_compliance_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    real(rk), contiguous, intent(in) :: unknowns(:)
    real(rk) :: bounds(size(self%bodies)), largest, limits(2, size(self%bodies)), total
    integer :: i

    do i = 1, size(bounds)
      bounds(i) = self%bodies(i)%error_bound(theta, self%with_closed_anchors(unknowns))
      limits(:, i) = self%bodies(i)%stiffness_limits(theta)
    end do
    ! the W of the other bodies reduces the effect of the openings of one body; the bounds of several bodies add up
    total = 0
    do i = 1, size(bounds)
      largest = maxval([limits(2, :i - 1), limits(2, i + 1:)])
      total = total + bounds(i) / sqrt(1 + self%bodies(i)%bound%share * limits(1, i) / largest)
    end do
    bound = min(norm2(bounds), total)
  end function own_error

  !> Returns 1 plus the relative error that training measured.
  pure real(rk) function foreign_factor(self)
    class(body_compliance_t), intent(in) :: self

    foreign_factor = 1 + self%measured_error
  end function foreign_factor

  !> Returns least_rounding (1e-10). If the responses of all bodies are exact, the error that was measured at the training points is
  !> rounding, too, and the larger number counts: a body that few contacts hold loses digits.
  pure real(rk) function rounding(self)
    class(body_compliance_t), intent(in) :: self
    integer :: i

    rounding = least_rounding
    do i = 1, size(self%bodies)
      if (size(self%bodies(i)%numerators) > 0) return
    end do
    rounding = max(rounding, self%measured_error)
  end function rounding
end module sig_body_compliance
