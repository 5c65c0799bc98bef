! SPDX-License-Identifier: BSD-3-Clause
!> Responses of one body to loads and contact forces as functions of its elastic constants. Training makes these data, and the model
!> file keeps them.
!>
!> Bodies have no common dofs, so W and q are sums over bodies. If all moduli of a body are multiplied by s, its responses to forces
!> are divided by s, and its responses to prescribed displacements do not change. This is exact. Responses are interpolated over the
!> other constants of the body: Poisson's ratios and ratios of moduli.
module sig_body_response
  use sig_errors, only: error_t
  use sig_hdf5_reader, only: h5_reader_t
  use sig_hdf5_writer, only: h5_writer_t
  use sig_interpolated_constants, only: to_variable, variable_change
  use sig_interpolation_bound, only: interpolation_bound_t, stiffness_rates, stiffness_ratios
  use sig_kinds, only: rk
  use sig_linear_algebra, only: multiply
  use sig_polynomial_nodes, only: most_variables, polynomial_nodes_t
  use sig_shape_checks, only: are_indices, is_ascending, is_matrix
  implicit none(type, external)
  private
  public :: body_response_t, body_weights_t

  !> Factors [-] of the responses at the nodes of the interpolation, shape (n_nodes): with the interpolation weights w, w / s of the
  !> responses to forces, and w of those to prescribed displacements. Or the changes of these factors.
  type :: body_weights_t
    real(rk), allocatable :: of_forces(:)
    real(rk), allocatable :: of_prescribed(:)
  end type body_weights_t

  type :: body_response_t
    !> term of the model that is the body's modulus, and the modulus [force/length**2] for which s = 1
    integer :: modulus_term = 0
    real(rk) :: modulus = 1
    !> interpolated constants: a term, divided by another term where that is not 0; shape (n_variables)
    integer, allocatable :: numerators(:)
    integer, allocatable :: denominators(:)
    !> whether the variables are logarithms (sig_interpolated_constants)
    logical :: is_logarithmic = .false.
    type(polynomial_nodes_t) :: nodes
    !> [length/force] the body's part of W at the nodes, column by column; shape (n_multipliers**2, n_nodes)
    real(rk), allocatable :: compliance(:, :)
    !> [length per unit of theta] its part of q: under loads, and under prescribed displacements; term by term, shape
    !> (n_multipliers * n_driving_terms, n_nodes)
    real(rk), allocatable :: loaded_opening(:, :)
    real(rk), allocatable :: prescribed_opening(:, :)
    !> [force*length per square unit of theta] U'K U of the displacements U under loads, and of those under prescribed
    !> displacements, at the nodes; shape (n_driving_terms**2, n_nodes)
    real(rk), allocatable :: loaded_energy(:, :)
    real(rk), allocatable :: prescribed_energy(:, :)
    !> the body's exact dofs, 1-based among those of the model, ascending; shape (n_own)
    integer, allocatable :: own(:)
    !> [length per unit of theta] displacements of these dofs, shape (n_own * n_driving_terms, n_nodes), and [length/force] their
    !> response to contact forces, shape (n_own * n_multipliers, n_nodes)
    real(rk), allocatable :: loaded_field(:, :)
    real(rk), allocatable :: prescribed_field(:, :)
    real(rk), allocatable :: contact_field(:, :)
    !> bound of the interpolation error, for one variable that is not a logarithm
    type(interpolation_bound_t) :: bound
    !> whether the model is plane stress
    logical :: is_thin = .false.
  contains
    procedure :: modulus_ratio
    procedure :: weights_at
    procedure :: change_weights
    procedure :: variables_at
    procedure :: add_compliance
    procedure :: add_closing
    procedure :: add_opening
    procedure :: add_field
    procedure :: has_bound
    procedure :: error_bound
    procedure :: field_bound
    procedure :: field_change_bound
    procedure :: field_change_size
    procedure :: driven_energy
    procedure :: stiffness_limits
    procedure :: stiffness_rate
    procedure :: opening_of_row
    procedure :: displacement_of
    procedure :: mismatch
    procedure :: write
    procedure :: read
  end type body_response_t

contains

  !> Returns s [-]: the body's modulus at a point (the term modulus_term), divided by its value in the responses (self%modulus).
  pure real(rk) function modulus_ratio(self, theta)
    class(body_response_t), intent(in) :: self
    !> values of the model's terms
    real(rk), intent(in) :: theta(:)

    modulus_ratio = theta(self%modulus_term) / self%modulus
  end function modulus_ratio

  !> Returns the factors of the nodes at a point, inside or outside of the box of the nodes. Requires: nodes%prepare.
  pure function weights_at(self, theta) result(weights)
    class(body_response_t), intent(in) :: self
    !> values of the model's terms
    real(rk), intent(in) :: theta(:)
    type(body_weights_t) :: weights

    allocate (weights%of_prescribed(self%nodes%n_nodes()))
    call self%nodes%weights(self%variables_at(theta), weights%of_prescribed)
    weights%of_forces = weights%of_prescribed / self%modulus_ratio(theta)
  end function weights_at

  !> Returns the changes, to first order, of these factors for a change of the terms. Responses are linear in the factors, in the
  !> terms and in the forces: their change is the response with the changed factors plus that to the changes of terms and forces.
  function change_weights(self, theta, theta_change) result(changes)
    class(body_response_t), intent(in) :: self
    !> values of the model's terms and their changes
    real(rk), contiguous, intent(in) :: theta(:)
    real(rk), contiguous, intent(in) :: theta_change(:)
    type(body_weights_t) :: changes
    type(body_weights_t) :: weights

    weights = self%weights_at(theta)
    allocate (changes%of_prescribed(self%nodes%n_nodes()))
    call self%nodes%weight_changes(self%variables_at(theta), variable_change(constants_at(self, theta), &
      constant_changes(self, theta, theta_change), self%denominators > 0, self%is_logarithmic), changes%of_prescribed)
    changes%of_forces = changes%of_prescribed / self%modulus_ratio(theta) - &
      weights%of_forces * scale_rate(self, theta, theta_change)
  end function change_weights

  !> Returns the changes [-] of constants_at, to first order, for a change of the terms.
  pure function constant_changes(self, theta, theta_change) result(changes)
    type(body_response_t), intent(in) :: self
    !> values of the model's terms and their changes
    real(rk), intent(in) :: theta(:)
    real(rk), intent(in) :: theta_change(:)
    !> shape (n_variables)
    real(rk) :: changes(size(self%numerators))
    real(rk) :: constants(size(self%numerators))
    integer :: i

    constants = constants_at(self, theta)
    do i = 1, size(constants)
      associate (above => self%numerators(i), below => self%denominators(i))
        changes(i) = theta_change(above)
        if (below > 0) changes(i) = (theta_change(above) - constants(i) * theta_change(below)) / theta(below)
      end associate
    end do
  end function constant_changes

  !> Returns the relative change s'/s of modulus_ratio for a change of the terms.
  pure real(rk) function scale_rate(self, theta, theta_change)
    type(body_response_t), intent(in) :: self
    !> values of the model's terms and their changes
    real(rk), intent(in) :: theta(:)
    real(rk), intent(in) :: theta_change(:)

    scale_rate = theta_change(self%modulus_term) / theta(self%modulus_term)
  end function scale_rate

  !> Returns the variables [-] of the interpolation at a point: the constants of constants_at or, if is_logarithmic, logarithms
  !> made from them (to_variable of sig_interpolated_constants).
  pure function variables_at(self, theta) result(variables)
    class(body_response_t), intent(in) :: self
    real(rk), intent(in) :: theta(:)
    !> shape (n_variables)
    real(rk) :: variables(size(self%numerators))

    variables = to_variable(constants_at(self, theta), self%denominators > 0, self%is_logarithmic)
  end function variables_at

  !> Returns the constants [-] over which the responses are interpolated, at a point: elastic constants, or ratios of two of them.
  pure function constants_at(self, theta) result(constants)
    type(body_response_t), intent(in) :: self
    real(rk), intent(in) :: theta(:)
    !> shape (n_variables)
    real(rk) :: constants(size(self%numerators))
    integer :: i

    do i = 1, size(constants)
      constants(i) = theta(self%numerators(i))
      if (self%denominators(i) > 0) constants(i) = constants(i) / theta(self%denominators(i))
    end do
  end function constants_at

  !> Adds the body's part of W to `compliance`; its rows of anchors are those of open anchors (sig_body_data).
  subroutine add_compliance(self, weights, compliance)
    class(body_response_t), intent(in) :: self
    type(body_weights_t), intent(in) :: weights
    !> [length/force] column by column, shape (n_multipliers**2)
    real(rk), contiguous, intent(inout) :: compliance(:)

    call multiply(1.0_rk, self%compliance, weights%of_forces, 1.0_rk, compliance)
  end subroutine add_compliance

  !> Adds the body's part of W z to `opening`.
  subroutine add_closing(self, weights, forces, opening)
    class(body_response_t), intent(in) :: self
    type(body_weights_t), intent(in) :: weights
    !> [force] z, zero on anchors; shape (n_multipliers)
    real(rk), contiguous, intent(in) :: forces(:)
    !> [length] shape (n_multipliers)
    real(rk), contiguous, intent(inout) :: opening(:)
    real(rk) :: compliance(size(self%compliance, 1))

    ! a parameter changes few bodies, so that weights are often zero
    if (.not. any(abs(weights%of_forces) > 0)) return
    call multiply(1.0_rk, self%compliance, weights%of_forces, 0.0_rk, compliance)
    call add_columns(size(opening), compliance, forces, opening)
  end subroutine add_closing

  !> Adds the body's part of q to `opening`: the openings of the contacts by loads and prescribed displacements, without the gaps D.
  subroutine add_opening(self, weights, theta, opening)
    class(body_response_t), intent(in) :: self
    type(body_weights_t), intent(in) :: weights
    !> values of the model's terms
    real(rk), contiguous, intent(in) :: theta(:)
    !> [length] shape (n_multipliers)
    real(rk), contiguous, intent(inout) :: opening(:)

    call add_driven(weights, self%loaded_opening, self%prescribed_opening, theta, opening)
  end subroutine add_opening

  !> Adds to `field` the displacement of the body's exact dofs by loads, prescribed displacements and contact forces, in the order
  !> of `own`. Rigid motions of the anchors are left out.
  subroutine add_field(self, weights, theta, forces, field)
    class(body_response_t), intent(in) :: self
    type(body_weights_t), intent(in) :: weights
    !> values of the model's terms
    real(rk), contiguous, intent(in) :: theta(:)
    !> [force] z, zero on anchors; shape (n_multipliers)
    real(rk), contiguous, intent(in) :: forces(:)
    !> [length] shape (n_own)
    real(rk), contiguous, intent(inout) :: field(:)
    real(rk) :: responses(size(self%contact_field, 1))

    call add_driven(weights, self%loaded_field, self%prescribed_field, theta, field)
    call multiply(1.0_rk, self%contact_field, weights%of_forces, 0.0_rk, responses)
    call add_columns(size(field), responses, -forces, field)
  end subroutine add_field

  !> Whether the responses of the body have an error bound. An exact body, which has no interpolated constants, has one, too.
  pure logical function has_bound(self)
    class(body_response_t), intent(in) :: self

    has_bound = size(self%numerators) == 0 .or. self%bound%is_there()
  end function has_bound

  !> Returns a bound [sqrt(force*length)] of the error that the interpolation of this body makes in the openings, in the norm of
  !> the inverse of the body's own W; 0 for an exact body (without interpolated constants). Requires: has_bound, nodes%prepare.
  real(rk) function error_bound(self, theta, forces) result(bound)
    class(body_response_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    !> [force] z, zero on anchors; shape (n_multipliers)
    real(rk), contiguous, intent(in) :: forces(:)
    real(rk) :: compliance(size(forces)**2), constants(size(self%numerators))

    bound = 0
    if (size(self%numerators) == 0) return
    constants = constants_at(self, theta)
    compliance = 0
    call self%add_compliance(self%weights_at(theta), compliance)
    bound = self%bound%evaluate(self%nodes%on_line(), constants(1), self%modulus_ratio(theta), self%denominators(1) > 0, &
      self%is_thin, bound_coefficients(self, theta, forces), reshape(compliance, [size(forces), size(forces)]))
  end function error_bound

  !> Returns a bound [sqrt(force*length)] of the error that the interpolation of this body makes in its displacement under the same
  !> contact forces, in the norm of its stiffness; 0 for an exact body. Requires: has_bound, nodes%prepare.
  real(rk) function field_bound(self, theta, forces) result(bound)
    class(body_response_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    !> [force] z, zero on anchors; shape (n_multipliers)
    real(rk), contiguous, intent(in) :: forces(:)
    real(rk) :: constants(size(self%numerators))

    bound = 0
    if (size(self%numerators) == 0) return
    constants = constants_at(self, theta)
    bound = self%bound%evaluate_field(self%nodes%on_line(), constants(1), self%modulus_ratio(theta), self%denominators(1) > 0, &
      self%is_thin, bound_coefficients(self, theta, forces))
  end function field_bound

  !> Returns a bound [sqrt(force*length) per unit of a parameter] of the derivative of the residual of this body's interpolated
  !> displacement, in the norm of the inverse of its stiffness; 0 for an exact body. Requires: has_bound, nodes%prepare.
  real(rk) function field_change_bound(self, theta, theta_change, forces, force_change) result(bound)
    class(body_response_t), intent(in) :: self
    !> values of the model's terms and their derivatives
    real(rk), contiguous, intent(in) :: theta(:)
    real(rk), contiguous, intent(in) :: theta_change(:)
    !> [force] z, zero on anchors, and its derivative; shape (n_multipliers)
    real(rk), contiguous, intent(in) :: forces(:)
    real(rk), contiguous, intent(in) :: force_change(:)
    real(rk), dimension(size(self%bound%residuals, 1)) :: changes, coefficients
    real(rk) :: constants(size(self%numerators)), slopes(size(self%numerators))
    integer :: n_driving

    bound = 0
    if (size(self%numerators) == 0) return
    constants = constants_at(self, theta)
    slopes = constant_changes(self, theta, theta_change)
    coefficients = bound_coefficients(self, theta, forces)
    changes = bound_coefficients(self, theta, force_change)
    n_driving = (size(coefficients) - size(forces)) / 2
    changes(:n_driving) = theta_change(:n_driving)
    changes(n_driving + 1:2 * n_driving) = self%modulus_ratio(theta) * &
      (theta_change(:n_driving) + scale_rate(self, theta, theta_change) * theta(:n_driving))
    bound = self%bound%evaluate_change(self%nodes%on_line(), constants(1), slopes(1), self%modulus_ratio(theta), &
      self%denominators(1) > 0, self%is_thin, coefficients, changes)
  end function field_change_bound

  !> Returns a lower bound [sqrt(force*length) per unit of a parameter] of the size |u'|_K of the derivative of the body's
  !> displacement, by sizes at the point. As the moduli change together, s' of sig_body_response, u' = w is the displacement under
  !> F' - F s'/s and z' - z s'/s; as the parts of the stiffness change at other rates, by d at most, |u' - w|_K <= d |u|_K. It is
  !> exact where no interpolated constant changes. Requires: has_bound, nodes%prepare.
  real(rk) function field_change_size(self, theta, theta_change, forces, force_change) result(size_of)
    class(body_response_t), intent(in) :: self
    !> the arguments are those of field_change_bound
    real(rk), contiguous, intent(in) :: theta(:)
    real(rk), contiguous, intent(in) :: theta_change(:)
    real(rk), contiguous, intent(in) :: forces(:)
    real(rk), contiguous, intent(in) :: force_change(:)
    real(rk) :: rate, others

    rate = scale_rate(self, theta, theta_change)
    others = maxval(abs(rates_of_parts(self, theta, theta_change) - rate))
    size_of = size_under(self, theta, theta_change - rate * theta, theta_change, force_change - rate * forces)
    if (others > 0) size_of = max(0.0_rk, size_of - others * size_under(self, theta, theta, theta, forces))
  end function field_change_size

  !> Returns |u|_K [sqrt(force*length)] of the body under given loads, prescribed displacements and forces, with the stiffness of a
  !> point.
  real(rk) function size_under(self, theta, loading, prescribing, forces) result(size_of)
    type(body_response_t), intent(in) :: self
    !> values of the model's terms for the elastic constants
    real(rk), contiguous, intent(in) :: theta(:)
    !> values of the terms for the loads and for the prescribed displacements
    real(rk), intent(in) :: loading(:)
    real(rk), intent(in) :: prescribing(:)
    !> [force] z, zero on anchors; shape (n_multipliers)
    real(rk), contiguous, intent(in) :: forces(:)
    real(rk) :: closing(size(forces))

    closing = 0
    call self%add_closing(self%weights_at(theta), forces, closing)
    size_of = sqrt(max(0.0_rk, dot_product(forces, closing) + energy_of(self, theta, loading, prescribing, forces)))
  end function size_under

  !> Returns the largest relative change of a part of the body's stiffness [per unit of a parameter], for derivatives of the terms:
  !> |K' u|_{K^-1} is at most this times |u|_K. Requires: has_bound.
  pure real(rk) function stiffness_rate(self, theta, theta_change)
    class(body_response_t), intent(in) :: self
    !> values of the model's terms and their derivatives
    real(rk), intent(in) :: theta(:)
    real(rk), intent(in) :: theta_change(:)

    stiffness_rate = maxval(abs(rates_of_parts(self, theta, theta_change)))
  end function stiffness_rate

  !> Returns the relative changes of the two parts of the body's stiffness.
  pure function rates_of_parts(self, theta, theta_change) result(rates)
    type(body_response_t), intent(in) :: self
    real(rk), intent(in) :: theta(:)
    real(rk), intent(in) :: theta_change(:)
    real(rk) :: rates(2)
    real(rk) :: constants(size(self%numerators)), slopes(size(self%numerators))

    rates = 0
    if (size(self%numerators) > 0) then
      constants = constants_at(self, theta)
      slopes = constant_changes(self, theta, theta_change)
      rates = stiffness_rates(constants(1), slopes(1), self%denominators(1) > 0, self%is_thin)
    end if
    rates = rates + scale_rate(self, theta, theta_change)
  end function rates_of_parts

  !> Returns the part of |u|_K^2 [force*length] of the body that depends on the driving terms. With s of sig_body_response, the
  !> displacements U_F under loads and U_D under prescribed displacements at s = 1, and H of the contact forces z,
  !>
  !>     |u|_K^2 = theta' (U_F'K U_F / s + s U_D'K U_D) theta - 2 z' H'K U_F theta / s + z'C z / s,
  !>
  !> because K U_D is zero where forces act. -H'K U_F is loaded_opening, and the last part is the share of the body in z'W z.
  real(rk) function driven_energy(self, theta, forces) result(energy)
    class(body_response_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    !> [force] z, zero on anchors; shape (n_multipliers)
    real(rk), contiguous, intent(in) :: forces(:)

    energy = energy_of(self, theta, theta, theta, forces)
  end function driven_energy

  !> Returns the same as driven_energy for any loads and prescribed displacements. The arguments are those of size_under.
  real(rk) function energy_of(self, theta, loading, prescribing, forces) result(energy)
    type(body_response_t), intent(in) :: self
    real(rk), intent(in) :: theta(:)
    real(rk), intent(in) :: loading(:)
    real(rk), intent(in) :: prescribing(:)
    real(rk), contiguous, intent(in) :: forces(:)
    real(rk), dimension(nint(sqrt(real(size(self%loaded_energy, 1), rk)))) :: loads, prescribed, products
    real(rk) :: opening(size(forces)), responses(size(self%loaded_opening, 1)), squares(size(self%loaded_energy, 1))
    type(body_weights_t) :: weights

    loads = loading(:size(loads))
    prescribed = prescribing(:size(prescribed))
    weights = self%weights_at(theta)
    products = 0
    call multiply(1.0_rk, self%loaded_energy, weights%of_forces, 0.0_rk, squares)
    call add_columns(size(products), squares, loads, products)
    energy = dot_product(loads, products)
    products = 0
    call multiply(self%modulus_ratio(theta), self%prescribed_energy, weights%of_prescribed, 0.0_rk, squares)
    call add_columns(size(products), squares, prescribed, products)
    energy = energy + dot_product(prescribed, products)
    opening = 0
    call multiply(1.0_rk, self%loaded_opening, weights%of_forces, 0.0_rk, responses)
    call add_columns(size(forces), responses, loads, opening)
    energy = energy + 2 * dot_product(forces, opening)
  end function energy_of

  !> Returns the coefficients x of sig_interpolation_bound at a point.
  function bound_coefficients(self, theta, forces) result(coefficients)
    type(body_response_t), intent(in) :: self
    real(rk), intent(in) :: theta(:)
    !> [force] z, zero on anchors; shape (n_multipliers)
    real(rk), intent(in) :: forces(:)
    real(rk) :: coefficients(size(self%bound%residuals, 1))
    integer :: n_driving

    n_driving = (size(coefficients) - size(forces)) / 2
    coefficients(:n_driving) = theta(:n_driving)
    coefficients(n_driving + 1:2 * n_driving) = self%modulus_ratio(theta) * theta(:n_driving)
    coefficients(2 * n_driving + 1:) = -forces
  end function bound_coefficients

  !> Returns two limits [-]: at a point, the stiffness of the body is at least the first and at most the second times the stiffness
  !> for which the bound was made (s = 1, constant bound%place). For an exact body (without interpolated constants) both are s.
  !> Requires: has_bound.
  pure function stiffness_limits(self, theta) result(limits)
    class(body_response_t), intent(in) :: self
    real(rk), intent(in) :: theta(:)
    real(rk) :: limits(2)
    real(rk) :: constants(size(self%numerators))

    limits = 1
    constants = constants_at(self, theta)
    if (size(constants) > 0) limits = stiffness_ratios(constants(1), self%bound%place, self%denominators(1) > 0, self%is_thin)
    limits = self%modulus_ratio(theta) * limits
  end function stiffness_limits

  !> Returns the body's part [length] of one row of W z + q, without the gap D; the row of an anchor is that of the open anchor.
  pure real(rk) function opening_of_row(self, weights, theta, forces, row) result(opening)
    class(body_response_t), intent(in) :: self
    type(body_weights_t), intent(in) :: weights
    real(rk), intent(in) :: theta(:)
    !> [force] z, zero on anchors; shape (n_multipliers)
    real(rk), intent(in) :: forces(:)
    !> row among the multipliers, 1-based
    integer, intent(in) :: row

    opening = value_of(weights, size(forces), row, self%loaded_opening, self%prescribed_opening, theta) + &
      sum_of_row(size(forces), row, self%compliance, weights%of_forces, forces)
  end function opening_of_row

  !> Returns the displacement [length] of one of the body's exact dofs, without rigid motions of the anchors.
  pure real(rk) function displacement_of(self, weights, theta, forces, i) result(displacement)
    class(body_response_t), intent(in) :: self
    type(body_weights_t), intent(in) :: weights
    real(rk), intent(in) :: theta(:)
    !> [force] z, zero on anchors; shape (n_multipliers)
    real(rk), intent(in) :: forces(:)
    !> place in `own`, 1-based
    integer, intent(in) :: i

    displacement = value_of(weights, size(self%own), i, self%loaded_field, self%prescribed_field, theta) - &
      sum_of_row(size(self%own), i, self%contact_field, weights%of_forces, forces)
  end function displacement_of

  !> Returns one row of (loaded / s + prescribed) theta(:n_driving_terms), where theta are the values of the model's terms.
  !> loaded and prescribed are given as `columns` of sum_of_row; n and row are those of sum_of_row.
  pure real(rk) function value_of(weights, n, row, loaded, prescribed, theta) result(value)
    type(body_weights_t), intent(in) :: weights
    integer, intent(in) :: n
    integer, intent(in) :: row
    real(rk), intent(in) :: loaded(:, :)
    real(rk), intent(in) :: prescribed(:, :)
    real(rk), intent(in) :: theta(:)

    associate (leading => theta(:size(loaded, 1) / n))
      value = sum_of_row(n, row, loaded, weights%of_forces, leading) + &
        sum_of_row(n, row, prescribed, weights%of_prescribed, leading)
    end associate
  end function value_of

  !> Returns one component of M x, where the matrix M is interpolated: the sum over the nodes of weight times matrix.
  pure real(rk) function sum_of_row(n, row, columns, weights, x) result(total)
    !> number of rows of the matrix
    integer, intent(in) :: n
    !> row of M, 1-based
    integer, intent(in) :: row
    !> the matrix at each node of the interpolation, column by column; shape (n * size(x), n_nodes)
    real(rk), intent(in) :: columns(:, :)
    !> [-] weight of each node, shape (n_nodes)
    real(rk), intent(in) :: weights(:)
    real(rk), intent(in) :: x(:)
    integer :: k

    total = 0
    if (.not. any(abs(weights) > 0)) return
    do k = 1, size(x)
      if (abs(x(k)) > 0) total = total + x(k) * dot_product(columns((k - 1) * n + row, :), weights)
    end do
  end function sum_of_row

  !> Adds (loaded / s + prescribed) theta(:n_driving_terms) to `values`.
  subroutine add_driven(weights, loaded, prescribed, theta, values)
    type(body_weights_t), intent(in) :: weights
    !> shape (size(values) * n_driving_terms, n_nodes)
    real(rk), contiguous, intent(in) :: loaded(:, :)
    real(rk), contiguous, intent(in) :: prescribed(:, :)
    !> [-] values of all terms of the model
    real(rk), contiguous, intent(in) :: theta(:)
    real(rk), contiguous, intent(inout) :: values(:)
    real(rk) :: responses(size(loaded, 1))

    if (size(values) == 0) return
    call multiply(1.0_rk, loaded, weights%of_forces, 0.0_rk, responses)
    call multiply(1.0_rk, prescribed, weights%of_prescribed, 1.0_rk, responses)
    call add_columns(size(values), responses, theta(:size(responses) / size(values)), values)
  end subroutine add_driven

  !> Computes y = y + a x; the caller may pass a as an array of rank 1, column by column.
  subroutine add_columns(n, a, x, y)
    integer, intent(in) :: n
    real(rk), contiguous, intent(in) :: x(:)
    real(rk), intent(in) :: a(n, size(x))
    real(rk), contiguous, intent(inout) :: y(:)

    call multiply(1.0_rk, a, x, 1.0_rk, y)
  end subroutine add_columns

  !> Returns the name of an array of this type whose shape or values do not fit the model, one of them if there are several; empty
  !> when all fit. The name `modulus` stands for modulus and modulus_term, and `lower`, `upper`, `nodes` and `residuals` for arrays
  !> of the components nodes and bound. Of the values of the nodes themselves, nothing is checked.
  pure function mismatch(self, n_multipliers, n_terms, n_exact) result(name)
    class(body_response_t), intent(in) :: self
    !> numbers of multipliers, terms and exact dofs of the model
    integer, intent(in) :: n_multipliers, n_terms, n_exact
    character(:), allocatable :: name
    integer :: n_driving, n_variables

    name = ''
    n_variables = size(self%numerators)
    n_driving = size(self%loaded_opening, 1) / max(1, n_multipliers)
    associate (n => n_multipliers, n_nodes => size(self%nodes%nodes, 2), n_own => size(self%own))
      if (.not. (are_indices([self%modulus_term], n_terms) .and. self%modulus > 0)) name = 'modulus'
      if (.not. (are_indices(self%numerators, n_terms) .and. all(self%denominators >= 0 .and. self%denominators <= n_terms) .and. &
                 size(self%denominators) == n_variables .and. n_variables <= most_variables)) name = 'numerators'
      if (size(self%nodes%lower) /= n_variables .or. size(self%nodes%upper) /= n_variables) name = 'lower'
      if (size(self%nodes%nodes, 1) /= n_variables .or. n_nodes == 0) name = 'nodes'
      if (.not. is_matrix(self%compliance, n**2, n_nodes)) name = 'compliance'
      if (n_driving > n_terms .or. .not. is_matrix(self%loaded_opening, n * n_driving, n_nodes)) name = 'loaded_opening'
      if (.not. is_matrix(self%prescribed_opening, n * n_driving, n_nodes)) name = 'prescribed_opening'
      if (.not. is_matrix(self%loaded_energy, n_driving**2, n_nodes)) name = 'loaded_energy'
      if (.not. is_matrix(self%prescribed_energy, n_driving**2, n_nodes)) name = 'prescribed_energy'
      if (.not. (are_indices(self%own, n_exact) .and. is_ascending(self%own))) name = 'own'
      if (.not. is_matrix(self%loaded_field, n_own * n_driving, n_nodes)) name = 'loaded_field'
      if (.not. is_matrix(self%prescribed_field, n_own * n_driving, n_nodes)) name = 'prescribed_field'
      if (.not. is_matrix(self%contact_field, n_own * n, n_nodes)) name = 'contact_field'
      if (self%bound%is_there() .and. (n_variables /= 1 .or. self%is_logarithmic .or. &
                                       .not. is_matrix(self%bound%residuals, 2 * n_driving + n, 2 * n_driving + n) .or. &
                                       .not. is_matrix(self%bound%rest, 2 * n_driving + n, 2 * n_driving + n) .or. &
                                       .not. is_matrix(self%bound%forces, n, 2 * n_driving + n) .or. &
                                       .not. self%bound%share >= 0)) name = 'residuals'
    end associate
    if (len(name) > 0) return
    if (any(.not. self%nodes%upper > self%nodes%lower)) name = 'upper'
  end function mismatch

  !> Writes the data to a group of a model file. A failure of the file is reported when the file is closed.
  subroutine write(self, file, group, length, force)
    class(body_response_t), intent(in) :: self
    type(h5_writer_t), intent(inout) :: file
    character(*), intent(in) :: group
    !> names of the units
    character(*), intent(in) :: length
    character(*), intent(in) :: force

    call file%write(group // '/modulus_term', self%modulus_term, description='term that is the modulus of the body, 1-based')
    call file%write(group // '/modulus', self%modulus, description='value of this modulus in the responses below')
    call file%write(group // '/numerators', self%numerators, description='terms (1-based) that the responses depend on')
    call file%write(group // '/denominators', self%denominators, description='terms (1-based) that these terms are ' // &
      'divided by; 0: none')
    call file%write(group // '/is_logarithmic', merge(1, 0, self%is_logarithmic), description='1: the interpolation is over ' // &
      'the logarithms of these constants')
    call file%write(group // '/lower', self%nodes%lower, description='lower and upper end of each constant of the interpolation')
    call file%write(group // '/upper', self%nodes%upper)
    call file%write(group // '/nodes', self%nodes%nodes, '1', 'nodes of the interpolation, a node per row; the box is ' // &
      'mapped to -1 ... 1')
    call file%write(group // '/compliance', self%compliance, length // '/(' // force // ')', &
      'opening of each contact under a unit contact force of each contact, a node of the interpolation per row')
    call file%write(group // '/loaded_opening', self%loaded_opening, length, 'opening of each contact under loads, term by term')
    call file%write(group // '/prescribed_opening', self%prescribed_opening, length, &
      'opening of each contact under prescribed displacements, term by term')
    call file%write(group // '/loaded_energy', self%loaded_energy, force // '*' // length, &
      'products of the displacements under loads in the norm of the stiffness, term by term')
    call file%write(group // '/prescribed_energy', self%prescribed_energy, force // '*' // length, &
      'products of the displacements under prescribed displacements in the norm of the stiffness, term by term')
    call file%write(group // '/own', self%own, description='exact dofs of the body: their numbers (1-based) among the exact ' // &
      'dofs of the model')
    call file%write(group // '/loaded_field', self%loaded_field, length, 'displacement of these dofs under loads, term by term')
    call file%write(group // '/prescribed_field', self%prescribed_field, length, &
      'displacement of these dofs under prescribed displacements, term by term')
    call file%write(group // '/contact_field', self%contact_field, length // '/(' // force // ')', &
      'minus the displacement of these dofs under a unit contact force, contact by contact')
    call file%write(group // '/is_thin', merge(1, 0, self%is_thin), description='1: plane stress, 0: another model')
    call self%bound%write(file, group, length, force)
  end subroutine write

  !> Reads the data from a group of a model file. Errors: a dataset is missing, or has another type or rank.
  subroutine read(self, file, group, error)
    class(body_response_t), intent(inout) :: self
    type(h5_reader_t), intent(in) :: file
    character(*), intent(in) :: group
    type(error_t), allocatable, intent(inout) :: error
    integer :: is_logarithmic, is_thin

    call file%read(group // '/modulus_term', self%modulus_term, error)
    call file%read(group // '/modulus', self%modulus, error)
    call file%read(group // '/numerators', self%numerators, error)
    call file%read(group // '/denominators', self%denominators, error)
    call file%read(group // '/is_logarithmic', is_logarithmic, error)
    self%is_logarithmic = is_logarithmic == 1
    call file%read(group // '/lower', self%nodes%lower, error)
    call file%read(group // '/upper', self%nodes%upper, error)
    call file%read(group // '/nodes', self%nodes%nodes, error)
    call file%read(group // '/compliance', self%compliance, error)
    call file%read(group // '/loaded_opening', self%loaded_opening, error)
    call file%read(group // '/prescribed_opening', self%prescribed_opening, error)
    call file%read(group // '/loaded_energy', self%loaded_energy, error)
    call file%read(group // '/prescribed_energy', self%prescribed_energy, error)
    call file%read(group // '/own', self%own, error)
    call file%read(group // '/loaded_field', self%loaded_field, error)
    call file%read(group // '/prescribed_field', self%prescribed_field, error)
    call file%read(group // '/contact_field', self%contact_field, error)
    call file%read(group // '/is_thin', is_thin, error)
    self%is_thin = is_thin == 1
    call self%bound%read(file, group, error)
  end subroutine read
end module sig_body_response
