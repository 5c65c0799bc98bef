! SPDX-License-Identifier: BSD-3-Clause
!> The displacement of one body by modes if its elastic constants depend on the parameters. Training makes these data, and the model
!> file keeps them.
!>
!> u = L theta + Phi a with liftings L of prescribed displacements and POD modes Phi. The modes are zero on dofs whose displacement
!> is prescribed. Galerkin's method gives a from the contact forces z:  sum_q k_q Phi'K_q Phi a = Phi'(F theta - B'z) - sum_q k_q
!> Phi'K_q L theta, where K_q are the bulk and shear parts of each material's stiffness at a place mu_0, and k_q are their moduli
!> over those at mu_0.
!>
!> The residual r is a combination, with coefficients c, of few columns: F, B', K_q L and K_q Phi. T is the triangle of these
!> columns in a basis that is orthonormal in the norm of K(mu_0)^-1. So |r|_{K^-1} <= |T c| / sqrt(min k_q), because K >= min k_q
!> K(mu_0). r is far smaller than its parts: with a matrix of products instead of T, rounding errors would be too large.
module sig_body_modes
  use sig_dense_kernels, only: factor_cholesky, multiply, multiply_transpose, solve_cholesky
  use sig_errors, only: error_t
  use sig_hdf5_reader, only: h5_reader_t
  use sig_hdf5_writer, only: h5_writer_t
  use sig_kinds, only: rk
  use sig_shape_checks, only: are_indices, is_ascending, is_matrix, place_in_ascending
  implicit none(type, external)
  private
  public :: body_modes_t, part_moduli

  !> The data of one body. In the units below the columns of L and Phi are lengths, and their factors theta and a have no unit.
  type :: body_modes_t
    !> dofs of the body, ascending, 1-based
    integer, allocatable :: dofs(:)
    !> [length] L and Phi, shape (size(dofs), n_lifted + n_modes)
    real(rk), allocatable :: basis(:, :)
    !> term of each column of L, 1-based, shape (n_lifted)
    integer, allocatable :: lifted_terms(:)
    !> terms of Young's modulus and Poisson's ratio of each material of the body, 1-based
    integer, allocatable :: modulus_terms(:)
    integer, allocatable :: ratio_terms(:)
    !> [force/length**2] moduli at mu_0, bulk and shear of each material in turn; shape (n_parts)
    real(rk), allocatable :: moduli(:)
    !> [force*length] V'K_q V with V = [L, Phi], column by column; shape (n_basis**2, n_parts)
    real(rk), allocatable :: stiffness(:, :)
    !> [force*length] Phi'F, shape (n_modes, n_driving_terms)
    real(rk), allocatable :: loads(:, :)
    !> [length] V'B', shape (n_basis, n_multipliers)
    real(rk), allocatable :: contact(:, :)
    !> [sqrt(force*length)] T, for the coefficients of F, of B', of K_1 V, K_2 V, ...
    real(rk), allocatable :: residuals(:, :)
    !> whether the model is plane stress
    logical :: is_thin = .false.
  contains
    procedure :: n_modes
    procedure :: solve
    procedure :: change
    procedure :: measure_change
    procedure :: add_closing
    procedure :: stiffest
    procedure :: stiffness_rate
    procedure :: add_field
    procedure :: displacement_of
    procedure :: mismatch
    procedure :: write
    procedure :: read
  end type body_modes_t

contains

  !> Returns the number of modes Phi; liftings do not count.
  pure integer function n_modes(self)
    class(body_modes_t), intent(in) :: self

    n_modes = size(self%basis, 2) - size(self%lifted_terms)
  end function n_modes

  !> Returns the bulk and the shear modulus [force/length**2] of a material, in this order; in plane stress the bulk modulus is that
  !> of the plane, E/(2 (1 - nu)). Hooke's matrix is linear in them (modulus_text of sig_elasticity).
  pure function part_moduli(young_modulus, poisson_ratio, is_thin) result(moduli)
    !> [force/length**2]
    real(rk), intent(in) :: young_modulus
    !> [-]
    real(rk), intent(in) :: poisson_ratio
    !> whether the model is plane stress
    logical, intent(in) :: is_thin
    real(rk) :: moduli(2)

    moduli(1) = young_modulus / (3 * (1 - 2 * poisson_ratio))
    if (is_thin) moduli(1) = young_modulus / (2 * (1 - poisson_ratio))
    moduli(2) = young_modulus / (2 * (1 + poisson_ratio))
  end function part_moduli

  !> Returns k_q [-] at a point: bulk and shear modulus of each material in turn, divided by self%moduli, their values at the place
  !> mu_0 for which the parts of the stiffness were computed; shape (n_parts).
  pure function part_ratios(self, theta) result(ratios)
    type(body_modes_t), intent(in) :: self
    !> values of the model's terms
    real(rk), intent(in) :: theta(:)
    real(rk) :: ratios(size(self%moduli))
    integer :: i

    do i = 1, size(self%modulus_terms)
      ratios(2 * i - 1:2 * i) = part_moduli(theta(self%modulus_terms(i)), theta(self%ratio_terms(i)), self%is_thin)
    end do
    ratios = ratios / self%moduli
  end function part_ratios

  !> Computes the coordinates a of the body's modes Phi under loads and contact forces. For the displacement u = L theta + Phi a,
  !> with the liftings L of prescribed values, it also computes u'K u and a bound of the residual r of equilibrium. If the reduced
  !> stiffness is not positive definite, the coordinates are zero, and the bound and u'K u are those of u = L theta.
  subroutine solve(self, theta, forces, coordinates, residual, energy)
    class(body_modes_t), intent(in) :: self
    !> values of the model's terms
    real(rk), contiguous, intent(in) :: theta(:)
    !> [force] z, zero on anchors; shape (n_multipliers)
    real(rk), contiguous, intent(in) :: forces(:)
    !> [length] shape (n_modes)
    real(rk), contiguous, intent(inout) :: coordinates(:)
    !> [sqrt(force*length)] upper bound of |r| in the norm of K^-1
    real(rk), intent(out) :: residual
    !> [force*length] u'K u
    real(rk), intent(out) :: energy
    real(rk) :: ratios(size(self%moduli)), place(size(self%basis, 2)), stiffness(size(self%basis, 2)**2)
    integer :: first, n_lifted

    n_lifted = size(self%lifted_terms)
    first = n_lifted + 1
    ratios = part_ratios(self, theta)
    call multiply(1.0_rk, self%stiffness, ratios, 0.0_rk, stiffness)
    place(:n_lifted) = theta(self%lifted_terms)
    call find_coordinates(self, size(place), stiffness, theta, forces, place)
    coordinates = place(first:)
    energy = work_of(size(place), stiffness, place)
    residual = size_of_residual(self, ratios, theta, forces, outer(place, ratios))
  end subroutine solve

  !> Computes the change da, to first order, of the coordinates of the modes for given changes of the terms and of the contact
  !> forces, from K_r da = Phi'(F dtheta - B'dz) - sum_q dk_q Phi'K_q u - Phi'K L dtheta with K_r = Phi'K Phi at the point. da is
  !> zero if K_r is not positive definite.
  subroutine change(self, theta, theta_change, coordinates, force_change, changes)
    class(body_modes_t), intent(in) :: self
    !> values of the model's terms and their changes, shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    real(rk), contiguous, intent(in) :: theta_change(:)
    !> [length] a, shape (n_modes)
    real(rk), intent(in) :: coordinates(:)
    !> [force] dz, zero on anchors; shape (n_multipliers)
    real(rk), contiguous, intent(in) :: force_change(:)
    !> [length] da, shape (n_modes)
    real(rk), intent(out) :: changes(:)
    real(rk) :: place(size(self%basis, 2)), place_change(size(self%basis, 2))
    real(rk) :: stiffness(size(place)**2), stiffness_change(size(place), size(place)), moved(size(place))
    integer :: n_lifted

    n_lifted = size(self%lifted_terms)
    place = [theta(self%lifted_terms), coordinates]
    place_change(:n_lifted) = theta_change(self%lifted_terms)
    call multiply(1.0_rk, self%stiffness, part_ratios(self, theta), 0.0_rk, stiffness)
    stiffness_change = reshape(matmul(self%stiffness, part_ratio_changes(self, theta, theta_change)), shape(stiffness_change))
    moved = matmul(stiffness_change, place)
    call find_coordinates(self, size(place), stiffness, theta_change, force_change, place_change, -moved(n_lifted + 1:))
    changes = place_change(n_lifted + 1:)
  end subroutine change

  !> Computes a bound of the derivative of the residual of equilibrium, r' = F theta' - B'z' - sum_q (k_q' K_q u + k_q K_q u'), and
  !> the size of the derivative u' of the displacement by modes.
  subroutine measure_change(self, theta, theta_change, coordinates, force_change, coordinate_change, residual, energy)
    class(body_modes_t), intent(in) :: self
    !> values of the model's terms and their derivatives, shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    real(rk), contiguous, intent(in) :: theta_change(:)
    !> [length] a, shape (n_modes)
    real(rk), intent(in) :: coordinates(:)
    !> [force] derivative of z, zero on anchors; shape (n_multipliers)
    real(rk), contiguous, intent(in) :: force_change(:)
    !> [length] derivative of a, result of change
    real(rk), intent(in) :: coordinate_change(:)
    !> [sqrt(force*length)] upper bound of |r'| in the norm of K^-1
    real(rk), intent(out) :: residual
    !> [force*length] u''K u'
    real(rk), intent(out) :: energy
    real(rk) :: place_change(size(self%basis, 2)), ratios(size(self%moduli)), stiffness(size(self%basis, 2)**2)

    place_change = [theta_change(self%lifted_terms), coordinate_change]
    ratios = part_ratios(self, theta)
    call multiply(1.0_rk, self%stiffness, ratios, 0.0_rk, stiffness)
    energy = work_of(size(place_change), stiffness, place_change)
    residual = size_of_residual(self, ratios, theta_change, force_change, outer(place_change, ratios) + &
      outer([theta(self%lifted_terms), coordinates], part_ratio_changes(self, theta, theta_change)))
  end subroutine measure_change

  !> Returns a b'.
  pure function outer(a, b)
    real(rk), intent(in) :: a(:)
    real(rk), intent(in) :: b(:)
    real(rk) :: outer(size(a), size(b))

    outer = spread(a, 2, size(b)) * spread(b, 1, size(a))
  end function outer

  !> Returns dk_q [-], the changes of part_ratios, to first order, for a change of the terms. Moduli are proportional to Young's
  !> modulus, and d ln(kappa)/d nu = 2/(1 - 2 nu), in plane stress 1/(1 - nu), d ln(G)/d nu = -1/(1 + nu).
  pure function part_ratio_changes(self, theta, theta_change) result(changes)
    type(body_modes_t), intent(in) :: self
    !> values of the model's terms and their changes, shape (n_terms)
    real(rk), intent(in) :: theta(:)
    real(rk), intent(in) :: theta_change(:)
    real(rk) :: changes(size(self%moduli))
    real(rk) :: bulk_slope
    integer :: i

    changes = part_ratios(self, theta)
    do i = 1, size(self%modulus_terms)
      associate (e => self%modulus_terms(i), nu => self%ratio_terms(i))
        bulk_slope = 2 / (1 - 2 * theta(nu))
        if (self%is_thin) bulk_slope = 1 / (1 - theta(nu))
        changes(2 * i - 1) = changes(2 * i - 1) * (theta_change(e) / theta(e) + bulk_slope * theta_change(nu))
        changes(2 * i) = changes(2 * i) * (theta_change(e) / theta(e) - theta_change(nu) / (1 + theta(nu)))
      end associate
    end do
  end function part_ratio_changes

  !> Adds B u to `closing`, for u = L theta + Phi a: the length by which the body closes each contact row. Its rigid motion by
  !> anchors is left out.
  subroutine add_closing(self, theta, coordinates, closing)
    class(body_modes_t), intent(in) :: self
    !> values of the model's terms
    real(rk), intent(in) :: theta(:)
    !> [length] a, shape (n_modes)
    real(rk), intent(in) :: coordinates(:)
    !> [length] shape (n_multipliers)
    real(rk), contiguous, intent(inout) :: closing(:)

    call multiply_transpose(1.0_rk, self%contact, [theta(self%lifted_terms), coordinates], 1.0_rk, closing)
  end subroutine add_closing

  !> Returns a factor b [-] with K <= b K(mu_0) for this body: the largest k_q.
  pure real(rk) function stiffest(self, theta)
    class(body_modes_t), intent(in) :: self
    !> values of the model's terms
    real(rk), intent(in) :: theta(:)

    stiffest = maxval(part_ratios(self, theta))
  end function stiffest

  !> Returns the largest |k_q'| / k_q [per unit of a parameter], for derivatives of the terms: |K' u|_{K^-1} is at most this times
  !> |u|_K.
  pure real(rk) function stiffness_rate(self, theta, theta_change)
    class(body_modes_t), intent(in) :: self
    !> values of the model's terms and their derivatives
    real(rk), intent(in) :: theta(:)
    real(rk), intent(in) :: theta_change(:)

    stiffness_rate = maxval(abs(part_ratio_changes(self, theta, theta_change)) / part_ratios(self, theta))
  end function stiffness_rate

  !> Solves Galerkin's equations for the coordinates of the modes. If the matrix of the equations is not positive definite, the
  !> coordinates of the modes are zero.
  subroutine find_coordinates(self, n, stiffness, theta, forces, place, further)
    type(body_modes_t), intent(in) :: self
    !> number of liftings and modes
    integer, intent(in) :: n
    !> [force*length] V'K V at the point, shape (n, n)
    real(rk), intent(in) :: stiffness(n, n)
    !> values of the terms, for F theta
    real(rk), contiguous, intent(in) :: theta(:)
    !> [force] z, zero on anchors; shape (n_multipliers)
    real(rk), contiguous, intent(in) :: forces(:)
    !> coordinates of liftings and modes, shape (n); in: those of the liftings, which stay; out: also those of the modes
    real(rk), contiguous, intent(inout) :: place(:)
    !> [force*length] work of further forces on the modes, shape (n_modes)
    real(rk), intent(in), optional :: further(:)
    real(rk) :: matrix(self%n_modes(), self%n_modes()), right(self%n_modes())
    integer :: info, k, n_lifted

    n_lifted = size(self%lifted_terms)
    call multiply(1.0_rk, self%loads, theta(:size(self%loads, 2)), 0.0_rk, right)
    call multiply(-1.0_rk, self%contact(n_lifted + 1:, :), forces, 1.0_rk, right)
    do k = 1, n_lifted
      right = right - stiffness(n_lifted + 1:, k) * place(k)
    end do
    if (present(further)) right = right + further
    matrix = stiffness(n_lifted + 1:, n_lifted + 1:)
    call factor_cholesky(size(right), matrix, info)
    if (info == 0) then
      call solve_cholesky(size(right), matrix, right)
    else
      right = 0
    end if
    place(n_lifted + 1:) = right
  end subroutine find_coordinates

  !> Returns the quadratic form x'Mx, or 0 where rounding makes it negative.
  real(rk) function work_of(n, matrix, x) result(work)
    integer, intent(in) :: n
    real(rk), intent(in) :: matrix(n, n)
    real(rk), contiguous, intent(in) :: x(:)
    real(rk) :: y(n)

    call multiply(1.0_rk, matrix, x, 0.0_rk, y)
    work = max(0.0_rk, dot_product(x, y))
  end function work_of

  !> Returns an upper bound [sqrt(force*length)] of |r| in the norm of K^-1, where r is the residual of equilibrium of the body.
  real(rk) function size_of_residual(self, ratios, theta, forces, places) result(residual)
    type(body_modes_t), intent(in) :: self
    !> [-] k_q from part_ratios
    real(rk), intent(in) :: ratios(:)
    real(rk), intent(in) :: theta(:)
    !> [force] z, zero on anchors; shape (n_multipliers)
    real(rk), intent(in) :: forces(:)
    !> coordinates of liftings and modes times k_q of each part, shape (n_lifted + n_modes, n_parts)
    real(rk), intent(in) :: places(:, :)
    real(rk) :: coefficients(size(self%residuals, 2)), reduced(size(self%residuals, 1))
    integer :: n

    n = size(self%loads, 2)
    coefficients(:n) = theta(:n)
    coefficients(n + 1:n + size(forces)) = -forces
    n = n + size(forces)
    coefficients(n + 1:) = -reshape(places, [size(places)])
    call multiply(1.0_rk, self%residuals, coefficients, 0.0_rk, reduced)
    residual = norm2(reduced) / sqrt(minval(ratios))
  end function size_of_residual

  !> Sets (and does not add to) the displacement L theta + Phi a of the body's dofs, without the rigid motion by its anchors. Other
  !> dofs stay unchanged.
  subroutine add_field(self, theta, coordinates, displacement)
    class(body_modes_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    !> [length] shape (n_modes)
    real(rk), contiguous, intent(in) :: coordinates(:)
    !> [length] displacement of all dofs, shape (n_dofs)
    real(rk), contiguous, intent(inout) :: displacement(:)
    real(rk) :: field(size(self%dofs))

    call multiply(1.0_rk, self%basis, [theta(self%lifted_terms), coordinates], 0.0_rk, field)
    displacement(self%dofs) = field
  end subroutine add_field

  !> Returns the displacement [length] of one dof, L theta + Phi a without the rigid motion by anchors; 0 for a dof of another body.
  pure real(rk) function displacement_of(self, theta, coordinates, dof) result(displacement)
    class(body_modes_t), intent(in) :: self
    real(rk), intent(in) :: theta(:)
    !> [length] a, shape (n_modes)
    real(rk), intent(in) :: coordinates(:)
    !> 1-based among those of the model
    integer, intent(in) :: dof
    integer :: i, row

    displacement = 0
    row = place_in_ascending(self%dofs, dof)
    if (row == 0) return
    do i = 1, size(self%lifted_terms)
      displacement = displacement + self%basis(row, i) * theta(self%lifted_terms(i))
    end do
    do i = 1, size(coordinates)
      displacement = displacement + self%basis(row, size(self%lifted_terms) + i) * coordinates(i)
    end do
  end function displacement_of

  !> Returns the name of an array of this type whose shape or values do not fit the model, one of them if there are several; empty
  !> when all fit. Requires: the arrays are allocated.
  pure function mismatch(self, n_dofs, n_multipliers, n_terms) result(name)
    class(body_modes_t), intent(in) :: self
    !> numbers of dofs, multipliers and terms of the model
    integer, intent(in) :: n_dofs, n_multipliers, n_terms
    character(:), allocatable :: name
    integer :: n_driving, n_parts

    name = ''
    n_parts = size(self%moduli)
    n_driving = size(self%loads, 2)
    associate (n => size(self%basis, 2))
      if (.not. (are_indices(self%dofs, n_dofs) .and. is_ascending(self%dofs))) name = 'dofs'
      if (.not. are_indices(self%lifted_terms, n_driving) .or. size(self%lifted_terms) > n) name = 'lifted_terms'
      if (.not. are_indices(self%modulus_terms, n_terms) .or. 2 * size(self%modulus_terms) /= n_parts .or. n_parts == 0) &
        name = 'modulus_terms'
      if (.not. are_indices(self%ratio_terms, n_terms) .or. 2 * size(self%ratio_terms) /= n_parts) name = 'ratio_terms'
      if (.not. is_matrix(self%stiffness, n**2, n_parts)) name = 'stiffness'
      if (n_driving > n_terms) name = 'loads'
      if (.not. is_matrix(self%residuals, size(self%residuals, 1), n_driving + n_multipliers + n * n_parts)) name = 'residuals'
      if (.not. is_matrix(self%basis, size(self%dofs), n)) name = 'basis'
    end associate
    if (len(name) > 0) return
    if (.not. is_matrix(self%loads, self%n_modes(), n_driving)) name = 'loads'
    if (.not. is_matrix(self%contact, size(self%basis, 2), n_multipliers)) name = 'contact'
    if (.not. all(self%moduli > 0)) name = 'moduli'
  end function mismatch

  !> Writes the data to a group of a model file. A failure of the file is reported when the file is closed.
  subroutine write(self, file, group, length, force)
    class(body_modes_t), intent(in) :: self
    type(h5_writer_t), intent(inout) :: file
    character(*), intent(in) :: group
    !> names of the units
    character(*), intent(in) :: length
    character(*), intent(in) :: force
    character(:), allocatable :: energy

    energy = force // '*' // length
    call file%write(group // '/dofs', self%dofs, description='dofs of the model that belong to the body, 1-based')
    call file%write(group // '/basis', self%basis, description= &
      'liftings of prescribed displacements, then modes; a lifting or a mode per row')
    call file%write(group // '/lifted_terms', self%lifted_terms, description='terms that the liftings belong to, 1-based')
    call file%write(group // '/modulus_terms', self%modulus_terms, description= &
      'terms of the Young''s moduli of the materials of the body, 1-based')
    call file%write(group // '/ratio_terms', self%ratio_terms, description='terms of the Poisson''s ratios of these ' // &
      'materials, 1-based')
    call file%write(group // '/moduli', self%moduli, force // '/' // length // '^2', &
      'bulk and shear modulus of each material, for which the parts below are')
    call file%write(group // '/stiffness', self%stiffness, energy, 'stiffness of the basis, a bulk or shear part per row')
    call file%write(group // '/loads', self%loads, energy, 'work of loads on the modes, a term per row')
    call file%write(group // '/contact', self%contact, length, 'closing of each contact by the basis, a contact per row')
    call file%write(group // '/residuals', self%residuals, 'sqrt(' // energy // ')', &
      'forces of loads, of contact and of the parts of the stiffness, in an orthonormal basis')
    call file%write(group // '/is_thin', merge(1, 0, self%is_thin), description='1: plane stress, 0: another model')
  end subroutine write

  !> Reads the data from a group of a model file. Errors: a dataset is missing, or has another type or rank.
  subroutine read(self, file, group, error)
    class(body_modes_t), intent(inout) :: self
    type(h5_reader_t), intent(in) :: file
    character(*), intent(in) :: group
    type(error_t), allocatable, intent(inout) :: error
    integer :: is_thin

    call file%read(group // '/dofs', self%dofs, error)
    call file%read(group // '/basis', self%basis, error)
    call file%read(group // '/lifted_terms', self%lifted_terms, error)
    call file%read(group // '/modulus_terms', self%modulus_terms, error)
    call file%read(group // '/ratio_terms', self%ratio_terms, error)
    call file%read(group // '/moduli', self%moduli, error)
    call file%read(group // '/stiffness', self%stiffness, error)
    call file%read(group // '/loads', self%loads, error)
    call file%read(group // '/contact', self%contact, error)
    call file%read(group // '/residuals', self%residuals, error)
    call file%read(group // '/is_thin', is_thin, error)
    self%is_thin = is_thin == 1
  end subroutine read
end module sig_body_modes
