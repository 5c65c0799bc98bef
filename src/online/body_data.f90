! SPDX-License-Identifier: BSD-3-Clause
!> The data of a condensed problem of bodies whose elastic constants depend on the parameters. Training makes them and a file keeps
!> them.
!>
!> W and q are sums over bodies (sig_body_response). The responses of the bodies have closed anchors, except in the rows of the
!> anchors themselves: these have open anchors, and give the distance by which the bodies move.
module sig_body_data
  use sig_body_modes, only: body_modes_t
  use sig_body_response, only: body_response_t, body_weights_t
  use sig_compliance, only: compliance_point_t, compliance_t
  use sig_errors, only: error_t
  use sig_hdf5_reader, only: h5_reader_t
  use sig_hdf5_writer, only: h5_writer_t
  use sig_kinds, only: rk
  use sig_linear_algebra, only: multiply
  use sig_missing_parts, only: fill_missing
  use sig_model_data, only: model_sizes_t
  use sig_rounding, only: rounding
  use sig_shape_checks, only: is_matrix
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: body_data_t

  type, abstract, extends(compliance_t) :: body_data_t
    type(body_response_t), allocatable :: bodies(:)
    !> [length per unit of theta] gaps D after motions that close the anchors; of anchors D itself; shape (n_multipliers, n_terms)
    real(rk), allocatable :: gap(:, :)
    !> [-] length by which all contacts close as each anchor closes by 1, shape (n_multipliers, n_anchors)
    real(rk), allocatable :: anchor_closing(:, :)
    !> [force per unit of theta] forces of the anchors, all closed, if no other contact has a force; shape (n_anchors, n_terms)
    real(rk), allocatable :: anchor_forces(:, :)
    !> [-] displacement of the exact dofs as an anchor closes by 1, shape (n_exact, n_anchors)
    real(rk), allocatable :: anchor_motions(:, :)
    !> displacements of the other dofs, one entry per body; empty: the other dofs have no displacement
    type(body_modes_t), allocatable :: modes(:)
    !> [-] displacement of all dofs as an anchor closes by 1, in a model with modes; shape (n_dofs, n_anchors)
    real(rk), allocatable :: mode_motions(:, :)
    !> [length/force] W of all bodies at the place mu_0 of the modes; empty where the displacement bound does not need it
    real(rk), allocatable :: middle_compliance(:, :)
    !> [-] largest error of the forces at the training points whose constants are not interpolation nodes, relative to the size of
    !> the forces, which counts as at least a thousandth of the largest size
    real(rk) :: measured_error = 0
    !> training point with this error, 1-based
    integer :: worst_point = 0
    !> number of factorizations in training
    integer :: n_factorizations = 0
  contains
    procedure :: complete
    procedure :: mismatch
    procedure :: add_up
    procedure :: opening_terms
    procedure :: has_material
    procedure :: has_bound
    procedure :: n_rows
    procedure :: has_modes
    procedure :: write
    procedure :: read
  end type body_data_t

contains

  !> Allocates with size 0 each array of this type and of its base type that is not allocated. Arrays inside of its bodies and modes
  !> stay as they are.
  pure subroutine complete(self, sizes)
    class(body_data_t), intent(inout) :: self
    type(model_sizes_t), intent(in) :: sizes

    call self%complete_shared(sizes)
    if (.not. allocated(self%bodies)) allocate (self%bodies(0))
    call fill_missing(self%gap, sizes%n_multipliers)
    call fill_missing(self%anchor_closing, sizes%n_multipliers)
    if (.not. allocated(self%anchor_forces)) allocate (self%anchor_forces(0, sizes%n_terms))
    call fill_missing(self%anchor_motions, size(self%exact_dofs))
    if (.not. allocated(self%modes)) allocate (self%modes(0))
    call fill_missing(self%mode_motions, merge(sizes%n_dofs, 0, size(self%modes) > 0))
    call fill_missing(self%middle_compliance, 0)
  end subroutine complete

  !> Returns the name of an array of this type, of one of its bodies or of one of its modes, whose shape or values do not fit the
  !> model; empty when all fit. The name does not say which body it is. Requires: complete or read.
  pure function mismatch(self, sizes) result(name)
    class(body_data_t), intent(in) :: self
    type(model_sizes_t), intent(in) :: sizes
    character(:), allocatable :: name
    integer :: i

    name = self%shared_mismatch(sizes)
    associate (n => sizes%n_multipliers, n_anchors => size(self%anchors), n_exact => size(self%exact_dofs))
      if (size(self%bodies) == 0) name = 'bodies'
      if (.not. is_matrix(self%gap, n, sizes%n_terms)) name = 'gap'
      if (.not. is_matrix(self%anchor_closing, n, n_anchors)) name = 'anchor_closing'
      if (.not. is_matrix(self%anchor_forces, n_anchors, sizes%n_terms)) name = 'anchor_forces'
      if (.not. is_matrix(self%anchor_motions, n_exact, n_anchors)) name = 'anchor_motions'
      do i = 1, size(self%bodies)
        if (len(name) == 0) name = self%bodies(i)%mismatch(n, sizes%n_terms, n_exact)
      end do
      do i = 1, size(self%modes)
        if (len(name) == 0) name = self%modes(i)%mismatch(sizes%n_dofs, n, sizes%n_terms)
      end do
      if (size(self%modes) > 0 .and. .not. is_matrix(self%mode_motions, sizes%n_dofs, n_anchors)) name = 'mode_motions'
      if (size(self%middle_compliance) > 0 .and. (size(self%modes) == 0 .or. .not. is_matrix(self%middle_compliance, n, n))) &
        name = 'middle_compliance'
    end associate
  end function mismatch

  !> Returns the number of contact rows; anchors count, too.
  pure integer function n_rows(self)
    class(body_data_t), intent(in) :: self

    n_rows = 0
    if (allocated(self%gap)) n_rows = size(self%gap, 1)
  end function n_rows

  !> Whether modes give the displacement of the dofs that are not exact.
  pure logical function has_modes(self)
    class(body_data_t), intent(in) :: self

    has_modes = .false.
    if (allocated(self%modes)) has_modes = size(self%modes) > 0
  end function has_modes

  !> Whether the elastic constants of all bodies are possible at a point: moduli and their ratios above 0, Poisson's ratios above -1
  !> and below 0.5.
  pure logical function has_material(self, theta)
    class(body_data_t), intent(in) :: self
    !> shape (n_terms)
    real(rk), intent(in) :: theta(:)
    integer :: i, k

    has_material = .true.
    do i = 1, size(self%bodies)
      associate (body => self%bodies(i))
        has_material = has_material .and. body%modulus_ratio(theta) > 0
        do k = 1, size(body%numerators)
          if (body%denominators(k) > 0) then
            has_material = has_material .and. theta(body%numerators(k)) / theta(body%denominators(k)) > 0
          else
            has_material = has_material .and. abs(theta(body%numerators(k)) + 0.25_rk) < 0.75_rk
          end if
        end do
      end associate
    end do
  end function has_material

  !> Computes W and q of the complementarity problem at a point; the unknowns of the anchors are their openings over `scale`.
  !> Requires: nodes%prepare of each body.
  subroutine add_up(self, theta, compliance, opening)
    class(body_data_t), intent(in) :: self
    !> shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    !> [length/force] shape (n_multipliers, n_multipliers)
    real(rk), contiguous, target, intent(inout) :: compliance(:, :)
    !> [length] shape (n_multipliers)
    real(rk), contiguous, intent(inout) :: opening(:)
    real(rk), pointer, contiguous :: flat(:)
    type(body_weights_t) :: weights
    integer :: i

    flat(1:size(compliance)) => compliance
    flat = 0
    call multiply(1.0_rk, self%gap, theta, 0.0_rk, opening)
    do i = 1, size(self%bodies)
      weights = self%bodies(i)%weights_at(theta)
      call self%bodies(i)%add_compliance(weights, flat)
      call self%bodies(i)%add_opening(weights, theta, opening)
    end do
    call close_anchors(self, theta, compliance, opening)
  end subroutine add_up

  !> Whether the model has a bound of the error that interpolation makes in the forces: each body is exact or has a bound.
  pure logical function has_bound(self)
    class(body_data_t), intent(in) :: self
    integer :: i

    has_bound = all([(self%bodies(i)%has_bound(), i=1, size(self%bodies))])
  end function has_bound

  !> Returns for each row the sum of the absolute values [length] of the terms of q: the gap for each term of theta, and the part of
  !> each body as one term. For an anchor these are its forces for each term of theta, times `scale`.
  function opening_terms(self, theta, point) result(terms)
    class(body_data_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    type(compliance_point_t), intent(in) :: point
    !> shape (n_multipliers)
    real(rk), allocatable :: terms(:)
    real(rk) :: of_body(size(self%gap, 1))
    integer :: i

    allocate (terms(size(self%gap, 1)), source=0.0_rk)
    do i = 1, size(theta)
      terms = terms + abs(self%gap(:, i) * theta(i))
    end do
    do i = 1, size(self%bodies)
      of_body = 0
      call self%bodies(i)%add_opening(self%bodies(i)%weights_at(theta), theta, of_body)
      terms = terms + abs(of_body)
    end do
    terms(self%anchors) = self%scale * matmul(abs(self%anchor_forces), abs(theta))
  end function opening_terms

  !> Overwrites the rows and columns of the anchors in W (compliance) and q (opening): the unknown of an anchor becomes its opening
  !> over `scale`, and its complementary value becomes its force times `scale`. q of an anchor is 0 if it is at most 1e-12 of the
  !> sum of the absolute values of its terms.
  pure subroutine close_anchors(self, theta, compliance, opening)
    class(body_data_t), intent(in) :: self
    real(rk), intent(in) :: theta(:)
    real(rk), intent(inout) :: compliance(:, :)
    real(rk), intent(inout) :: opening(:)
    real(rk) :: force
    integer :: i, k

    do i = 1, size(self%anchors)
      associate (row => self%anchors(i))
        compliance(:, row) = self%scale * self%anchor_closing(:, i)
        compliance(row, :) = -self%scale * self%anchor_closing(:, i)
        force = 0
        do k = 1, size(theta)
          force = force + self%anchor_forces(i, k) * theta(k)
        end do
        if (abs(force) <= rounding * sum(abs(self%anchor_forces(i, :) * theta))) force = 0
        opening(row) = self%scale * force
      end associate
    end do
    compliance(self%anchors, self%anchors) = 0
  end subroutine close_anchors

  !> Writes the data to a group of a model file. A failure of the file is reported when the file is closed.
  subroutine write(self, file, group, length, force)
    class(body_data_t), intent(in) :: self
    type(h5_writer_t), intent(inout) :: file
    character(*), intent(in) :: group
    !> names of the units
    character(*), intent(in) :: length
    character(*), intent(in) :: force
    integer :: i

    call self%write_shared(file, group, length, force)
    call self%write_anchors(file, group, length, force)
    call file%write(group // '/n_bodies', size(self%bodies), description='number of groups below bodies')
    do i = 1, size(self%bodies)
      call self%bodies(i)%write(file, group // '/bodies/' // to_text(i), length, force)
    end do
    call file%write(group // '/n_modes', size(self%modes), description='number of groups below modes')
    do i = 1, size(self%modes)
      call self%modes(i)%write(file, group // '/modes/' // to_text(i), length, force)
    end do
    call file%write(group // '/mode_motions', self%mode_motions, '1', &
      'displacement of all dofs as an anchor closes by 1, an anchor per row; of a model with modes')
    call file%write(group // '/middle_compliance', self%middle_compliance, length // '/(' // force // ')', &
      'opening of each contact under a unit contact force of each contact at the moduli of the modes; empty: bounds do not need it')
    call file%write(group // '/gap', self%gap, length, 'initial gap of each contact with closed anchors, of an anchor ' // &
      'with open ones; a term per row')
    call file%write(group // '/anchor_closing', self%anchor_closing, '1', 'how far each contact closes as an anchor closes by ' // &
      '1, an anchor per row')
    call file%write(group // '/anchor_forces', self%anchor_forces, force, 'forces of the anchors where no other contact has ' // &
      'a force, a term per row')
    call file%write(group // '/anchor_motions', self%anchor_motions, '1', &
      'displacement of the exact dofs as an anchor closes by 1, an anchor per row')
    call file%write(group // '/measured_error', self%measured_error, '1', &
      'largest error of the contact forces at the training points, relative')
    call file%write(group // '/worst_point', self%worst_point, description='training point (1-based) with this largest error')
    call file%write(group // '/n_factorizations', self%n_factorizations, description='number of factorizations of the ' // &
      'stiffness in training')
  end subroutine write

  !> Reads the data from a group of a model file. Errors: a dataset is missing, or has another type or rank. If the group of a body
  !> is missing, `bodies` becomes empty; if the group of the modes of a body is missing, `modes` becomes empty.
  subroutine read(self, file, group, error)
    class(body_data_t), intent(inout) :: self
    type(h5_reader_t), intent(in) :: file
    character(*), intent(in) :: group
    type(error_t), allocatable, intent(inout) :: error
    integer :: i, n_bodies, n_modes

    call self%read_shared(file, group, error)
    call self%read_anchors(file, group, error)
    call file%read(group // '/n_bodies', n_bodies, error)
    call file%read(group // '/n_modes', n_modes, error)
    if (allocated(error)) return
    ! a file may name any number of bodies, so it is checked
    allocate (self%bodies(file%all_groups(group // '/bodies', n_bodies)))
    do i = 1, size(self%bodies)
      call self%bodies(i)%read(file, group // '/bodies/' // to_text(i), error)
    end do
    allocate (self%modes(file%all_groups(group // '/modes', n_modes)))
    do i = 1, size(self%modes)
      call self%modes(i)%read(file, group // '/modes/' // to_text(i), error)
    end do
    call file%read(group // '/mode_motions', self%mode_motions, error)
    call file%read(group // '/middle_compliance', self%middle_compliance, error)
    call file%read(group // '/gap', self%gap, error)
    call file%read(group // '/anchor_closing', self%anchor_closing, error)
    call file%read(group // '/anchor_forces', self%anchor_forces, error)
    call file%read(group // '/anchor_motions', self%anchor_motions, error)
    call file%read(group // '/measured_error', self%measured_error, error)
    call file%read(group // '/worst_point', self%worst_point, error)
    call file%read(group // '/n_factorizations', self%n_factorizations, error)
  end subroutine read
end module sig_body_data
