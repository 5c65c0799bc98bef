! SPDX-License-Identifier: BSD-3-Clause
!> Bound of the error in the contact forces that comes from interpolation over one elastic constant of a body.
!>
!> K becomes affine in the constant c after multiplication by a factor: p(c) K(c) / s is affine in c. U_I are responses that are
!> interpolated at n nodes (n >= 3). So the residual p F - p K U_I / s is a polynomial of degree n that is zero at the nodes: w(c) Z
!> with w(c) = prod (c - c_i) and constant Z. Therefore one more response, U at a place c_0, gives the norms of all residuals: with
!> E = U - U_I, Z'K_0^-1 Z = (p/w)^2(c_0) E'K_0 E.
!>
!> The residual r = (w/p) Z x is split into forces on the contacts and the rest, r = B'y + r' with B K_0^-1 r' = 0. With alpha and
!> beta such that alpha K_0 <= K <= beta K_0, the errors B K^-1 r of the openings are in the norm of W^-1 at most
!> |y|_W + |r'|_0 (1 - sqrt(alpha/beta)) / sqrt(alpha): the last because B K^-1 r' = B (K^-1 - K_0^-1/gamma) r' for any gamma, and
!> gamma = sqrt(alpha beta) is the best one.
module sig_interpolation_bound
  use sig_errors, only: error_t
  use sig_hdf5_reader, only: h5_reader_t
  use sig_hdf5_writer, only: h5_writer_t
  use sig_kinds, only: rk
  use sig_linear_algebra, only: multiply
  implicit none(type, external)
  private
  public :: interpolation_bound_t, node_product, stiffness_factor, stiffness_rates, stiffness_ratios

  type :: interpolation_bound_t
    !> [-] c_0, the value of the constant at which the additional response was computed
    real(rk) :: place = 0
    !> [force*length per square of a coefficient] Z'K_0^-1 Z, for the coefficients of loads, of prescribed displacements, of contact
    !> forces; empty: there is no bound
    real(rk), allocatable :: residuals(:, :)
    !> [force*length per square of a coefficient] the same as `residuals` for the part r' of the residual
    real(rk), allocatable :: rest(:, :)
    !> [force per unit of a coefficient] y, shape (n_multipliers, n_coefficients)
    real(rk), allocatable :: forces(:, :)
    !> [-] a factor: the W of all other bodies together is at least this times the W of the body, if all bodies have s = 1 and the
    !> constant `place` of their own bounds; 0: no such factor is known
    real(rk) :: share = 0
  contains
    procedure :: is_there
    procedure :: evaluate
    procedure :: evaluate_field
    procedure :: evaluate_change
    procedure :: write
    procedure :: read
  end type interpolation_bound_t

contains

  !> Whether there are data for a bound.
  pure logical function is_there(self)
    class(interpolation_bound_t), intent(in) :: self

    is_there = .false.
    if (allocated(self%residuals)) is_there = size(self%residuals) > 0
  end function is_there

  !> Returns a bound [sqrt(force*length)] of the error that interpolation makes in the openings by one body, in the norm of the
  !> inverse of the body's W. Requires: is_there.
  real(rk) function evaluate(self, nodes, constant, modulus_ratio, is_ratio_of_moduli, is_thin, coefficients, compliance) &
    result(bound)
    class(interpolation_bound_t), intent(in) :: self
    !> [-] c_i, values of the constant at the interpolation nodes, shape (n_nodes)
    real(rk), intent(in) :: nodes(:)
    !> [-] c, value of the constant at the point
    real(rk), intent(in) :: constant
    !> [-] s, factor of all moduli of the body
    real(rk), intent(in) :: modulus_ratio
    !> whether the constant is a ratio of moduli; otherwise it is a Poisson's ratio
    logical, intent(in) :: is_ratio_of_moduli
    !> whether the model is plane stress
    logical, intent(in) :: is_thin
    !> x, in the order of `residuals`: the driving terms theta for the loads, s theta for the prescribed displacements, and [force]
    !> the contact forces times -1
    real(rk), contiguous, intent(in) :: coefficients(:)
    !> [length/force] W of the body at the point, shape (n_multipliers, n_multipliers)
    real(rk), contiguous, intent(in) :: compliance(:, :)
    real(rk) :: factor, forces(size(compliance, 1)), closing(size(compliance, 1)), ratios(2)

    factor = abs(node_product(nodes, constant) / stiffness_factor(constant, is_ratio_of_moduli, is_thin))
    ratios = modulus_ratio * stiffness_ratios(constant, self%place, is_ratio_of_moduli, is_thin)
    call multiply(1.0_rk, self%forces, coefficients, 0.0_rk, forces)
    call multiply(1.0_rk, compliance, forces, 0.0_rk, closing)
    bound = sqrt(max(0.0_rk, dot_product(forces, closing))) + &
      size_in(self%rest, coefficients) * (1 - sqrt(ratios(1) / ratios(2))) / sqrt(ratios(1))
    bound = min(factor * bound, self%evaluate_field(nodes, constant, modulus_ratio, is_ratio_of_moduli, is_thin, coefficients))
  end function evaluate

  !> Returns a bound [sqrt(force*length)] of the error that interpolation makes in the displacement of the body under the same
  !> contact forces, in the norm of its stiffness: |r|_{K^-1}. The arguments are those of evaluate. Requires: is_there.
  real(rk) function evaluate_field(self, nodes, constant, modulus_ratio, is_ratio_of_moduli, is_thin, coefficients) result(bound)
    class(interpolation_bound_t), intent(in) :: self
    real(rk), intent(in) :: nodes(:)
    real(rk), intent(in) :: constant
    real(rk), intent(in) :: modulus_ratio
    logical, intent(in) :: is_ratio_of_moduli
    logical, intent(in) :: is_thin
    real(rk), contiguous, intent(in) :: coefficients(:)
    real(rk) :: factor, ratios(2)

    factor = abs(node_product(nodes, constant) / stiffness_factor(constant, is_ratio_of_moduli, is_thin))
    ratios = modulus_ratio * stiffness_ratios(constant, self%place, is_ratio_of_moduli, is_thin)
    bound = factor * size_in(self%residuals, coefficients) / sqrt(ratios(1))
  end function evaluate_field

  !> Returns a bound [sqrt(force*length) per unit of a parameter] of the derivative of the residual r = (w/p) Z x, as the constant
  !> and the coefficients x change: |(w/p)' Z x + (w/p) Z x'|_{K^-1}. The other arguments are those of evaluate. Requires: is_there.
  real(rk) function evaluate_change(self, nodes, constant, constant_change, modulus_ratio, is_ratio_of_moduli, is_thin, &
    coefficients, coefficient_changes) result(bound)
    class(interpolation_bound_t), intent(in) :: self
    real(rk), intent(in) :: nodes(:)
    real(rk), intent(in) :: constant
    !> [per unit of the parameter] derivatives of c and of x
    real(rk), intent(in) :: constant_change
    real(rk), intent(in) :: modulus_ratio
    logical, intent(in) :: is_ratio_of_moduli
    logical, intent(in) :: is_thin
    real(rk), contiguous, intent(in) :: coefficients(:)
    real(rk), contiguous, intent(in) :: coefficient_changes(:)
    real(rk) :: factor, factor_slope, p, product_slope, ratios(2)
    integer :: i

    p = stiffness_factor(constant, is_ratio_of_moduli, is_thin)
    factor = node_product(nodes, constant) / p
    product_slope = sum([(node_product([nodes(:i - 1), nodes(i + 1:)], constant), i=1, size(nodes))])
    factor_slope = (product_slope - factor * stiffness_factor_slope(constant, is_ratio_of_moduli, is_thin)) / p
    ratios = modulus_ratio * stiffness_ratios(constant, self%place, is_ratio_of_moduli, is_thin)
    bound = size_in(self%residuals, factor_slope * constant_change * coefficients + factor * coefficient_changes) / sqrt(ratios(1))
  end function evaluate_change

  !> Returns sqrt(x'Mx), or 0 where rounding makes x'Mx negative.
  real(rk) function size_in(matrix, x)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    real(rk), contiguous, intent(in) :: x(:)
    real(rk) :: y(size(x))

    call multiply(1.0_rk, matrix, x, 0.0_rk, y)
    size_in = sqrt(max(0.0_rk, dot_product(x, y)))
  end function size_in

  !> Returns w(c), the product of the differences c - c_i to all nodes.
  pure real(rk) function node_product(nodes, constant)
    !> [-] c_i, shape (n_nodes)
    real(rk), intent(in) :: nodes(:)
    !> [-] c
    real(rk), intent(in) :: constant

    node_product = product(constant - nodes)
  end function node_product

  !> Returns p(c) [-]. For a Poisson's ratio c it is (1 + c)(1 - 2 c), in plane stress (1 + c)(1 - c): p times the stiffness of a
  !> material with Young's modulus 1 is affine in c. For a ratio of moduli p = 1.
  pure real(rk) function stiffness_factor(constant, is_ratio_of_moduli, is_thin) result(factor)
    !> [-] c; the next two: as for evaluate
    real(rk), intent(in) :: constant
    logical, intent(in) :: is_ratio_of_moduli
    logical, intent(in) :: is_thin

    factor = 1
    if (is_ratio_of_moduli) return
    factor = (1 + constant) * (1 - 2 * constant)
    if (is_thin) factor = (1 + constant) * (1 - constant)
  end function stiffness_factor

  !> Returns p'(c) [-].
  pure real(rk) function stiffness_factor_slope(constant, is_ratio_of_moduli, is_thin) result(slope)
    !> [-] c; the next two: as for evaluate
    real(rk), intent(in) :: constant
    logical, intent(in) :: is_ratio_of_moduli
    logical, intent(in) :: is_thin

    slope = 0
    if (is_ratio_of_moduli) return
    slope = -1 - 4 * constant
    if (is_thin) slope = -2 * constant
  end function stiffness_factor_slope

  !> Returns the derivatives of the logarithms of the two parts of the stiffness (stiffness_ratios) for s = 1, as the constant
  !> changes: the largest in size is the most by which K' exceeds K.
  pure function stiffness_rates(constant, constant_change, is_ratio_of_moduli, is_thin) result(rates)
    !> [-] c, and [per unit of a parameter] its derivative
    real(rk), intent(in) :: constant
    real(rk), intent(in) :: constant_change
    !> this and the next: as for evaluate
    logical, intent(in) :: is_ratio_of_moduli
    logical, intent(in) :: is_thin
    !> [per unit of the parameter]
    real(rk) :: rates(2)

    if (is_ratio_of_moduli) then
      rates = [0.0_rk, constant_change / constant]
    else if (is_thin) then
      rates = constant_change * [1 / (1 - constant), -1 / (1 + constant)]
    else
      rates = constant_change * [2 / (1 - 2 * constant), -1 / (1 + constant)]
    end if
  end function stiffness_rates

  !> Returns alpha and beta [-] with alpha K(c_0) <= K(c) <= beta K(c_0) for equal s: the least and the largest ratio of the parts
  !> of the stiffness at c to those at c_0. These parts are two materials, or bulk and shear.
  pure function stiffness_ratios(constant, place, is_ratio_of_moduli, is_thin) result(ratios)
    !> [-] c and c_0
    real(rk), intent(in) :: constant
    real(rk), intent(in) :: place
    !> this and the next: as for evaluate
    logical, intent(in) :: is_ratio_of_moduli
    logical, intent(in) :: is_thin
    real(rk) :: ratios(2)

    if (is_ratio_of_moduli) then
      ratios = [1.0_rk, constant / place]
    else if (is_thin) then
      ratios = [(1 - place) / (1 - constant), (1 + place) / (1 + constant)]
    else
      ratios = [(1 - 2 * place) / (1 - 2 * constant), (1 + place) / (1 + constant)]
    end if
    ratios = [minval(ratios), maxval(ratios)]
  end function stiffness_ratios

  !> Writes the data to the group of a body of a model file. A failure of the file is reported when the file is closed.
  subroutine write(self, file, group, length, force)
    class(interpolation_bound_t), intent(in) :: self
    type(h5_writer_t), intent(inout) :: file
    character(*), intent(in) :: group
    !> names of the units
    character(*), intent(in) :: length
    character(*), intent(in) :: force

    call file%write(group // '/residual_place', self%place, description='constant at which the residuals were measured')
    call file%write(group // '/residuals', self%residuals, force // '*' // length, &
      'products of the residuals of interpolation over the constant: of loads, of prescribed displacements, of contact forces')
    call file%write(group // '/residual_rest', self%rest, force // '*' // length, 'products of ' // &
      'the parts of these residuals that open no contact at residual_place')
    call file%write(group // '/residual_forces', self%forces, force, &
      'contact forces that are the other parts of these residuals, a residual per row')
    call file%write(group // '/residual_share', self%share, '1', &
      'lower bound of the compliance of all other bodies together, over that of the body; at residual_place')
  end subroutine write

  !> Reads the data from the group of a body of a model file. Errors: a dataset is missing, or has another type or rank.
  subroutine read(self, file, group, error)
    class(interpolation_bound_t), intent(inout) :: self
    type(h5_reader_t), intent(in) :: file
    character(*), intent(in) :: group
    type(error_t), allocatable, intent(inout) :: error

    call file%read(group // '/residual_place', self%place, error)
    call file%read(group // '/residuals', self%residuals, error)
    call file%read(group // '/residual_rest', self%rest, error)
    call file%read(group // '/residual_forces', self%forces, error)
    call file%read(group // '/residual_share', self%share, error)
  end subroutine read
end module sig_interpolation_bound
