! SPDX-License-Identifier: BSD-3-Clause
!> Where W and q of a contact problem condensed to its contacts come from, and what their solution means for displacements:
!>
!>     0 <= z, W(mu) z + q(mu) >= 0, complementary.
!>
!> z are the contact forces. Anchors are contacts that are taken as closed to hold bodies that only contact holds. For an anchor the
!> unknown is its opening over `scale` instead of its force, and the complementary value is its force times `scale` instead of its
!> opening.
!>
!> An implementation may have several systems W and q, each of which has unknowns at some rows only, and expands their forces to all
!> rows.
!>
!> Everything that a condensed model does (sig_condensed_model) is written for this type. An implementation says how W and q depend
!> on the point, and what it knows of its error.
module sig_compliance
  use sig_answer, only: answer_t, comparable_size, no_bound
  use sig_bits, only: n_words, unpack_bits
  use sig_contact_laws, only: contact_laws_t
  use sig_errors, only: error_t
  use sig_gradient, only: gradient_t
  use sig_hdf5_reader, only: h5_reader_t
  use sig_hdf5_writer, only: h5_writer_t
  use sig_kinds, only: rk
  use sig_lcp, only: lcp_solution_t, lcp_workspace_t
  use sig_lcp_rounding, only: drop_forces
  use sig_missing_parts, only: fill_missing
  use sig_model_data, only: model_data_t, model_sizes_t
  use sig_reduced, only: displacement_by_modes, displacement_exact, displacement_none
  use sig_rounding, only: rounding_of_data, size_rounding => rounding
  use sig_shape_checks, only: are_indices, is_ascending, place_in_ascending
  use sig_text, only: join, string_t
  implicit none(type, external)
  private
  public :: compliance_t, compliance_point_t, round_work

  !> What belongs to one point: work arrays of one thread.
  type :: compliance_point_t
    !> number of the system of the compliance, 1-based
    integer :: i_system = 1
    !> [length] q, shape (n_unknowns)
    real(rk), allocatable :: opening(:)
    !> [length] what opens the contacts besides the terms, part of q; not allocated where nothing does. Shape (n_unknowns)
    real(rk), allocatable :: other_opening(:)
    !> [length/force] W, shape (n_unknowns, n_unknowns); size 0 where W is the same at all points
    real(rk), allocatable :: matrix(:, :)
    !> what a compliance keeps of all rows while it solves, shape (n_rows)
    real(rk), allocatable :: rows(:)
    !> [sqrt(force*length)] of a displacement by modes that solve_modes found: bound of the residual of equilibrium, and size
    real(rk) :: residual = 0
    real(rk) :: field_size = 0
  end type compliance_point_t

  type, abstract, extends(model_data_t) :: compliance_t
    !> dofs whose displacement under the forces of the answer is exact (where W is interpolated, except for the interpolation),
    !> ascending, 1-based, shape (n_exact): those of all nodes, or of the boundaries that the deck names, or none
    integer, allocatable :: exact_dofs(:)
    !> boundaries that the deck names for these dofs; empty if they are those of all nodes, or if there are none
    type(string_t), allocatable :: exact_boundaries(:)
    !> active sets (z > 0) at the training points, as bits; shape (n_words(n_multipliers), n_points), or no columns
    integer, allocatable :: start_sets(:, :)
    !> rows that are anchors, 1-based
    integer, allocatable :: anchors(:)
    !> [length/force] scale of the anchors
    real(rk) :: scale = 1
    !> [length/force] at most the smallest eigenvalue of a fixed W of the rows that are not anchors; 0: not known
    real(rk) :: least_eigenvalue = 0
    !> [sqrt(force*length)] largest size of the forces in training, in the norm of W
    real(rk) :: largest_size = 0
    !> [sqrt(force*length)] largest size of the displacement in training, in the norm of the stiffness
    real(rk) :: largest_field = 0
  contains
    procedure(has_it), deferred :: has_modes
    procedure(has_it), deferred :: is_fixed
    procedure(evaluate_at), deferred :: evaluate
    procedure(matrix_at), deferred :: matrix
    procedure(terms_at), deferred :: opening_terms
    procedure(change_at), deferred :: change_openings
    procedure(change_field_at), deferred :: change_field
    procedure(size_at), deferred :: size_of_field
    procedure(size_at), deferred :: field_error
    ! an implementation may say more
    procedure :: prepare => nothing_to_prepare
    procedure :: solve_near => not_tried
    procedure :: create_point => usual_point
    procedure :: drop_rounding => drop_small_forces
    procedure :: anchor_motion => no_motion
    procedure :: n_systems => one_system
    procedure :: first_system => first_of_one
    procedure :: start_from => usual_start
    procedure :: expand => take_forces
    procedure :: expand_step => nothing_to_complete
    procedure :: expand_changes => nothing_to_expand
    procedure :: laws_of_unknowns => all_laws
    procedure :: n_modes => no_coordinates
    procedure :: solve_modes => nothing_to_solve
    procedure :: complete_gradient => nothing_to_add
    procedure :: has_bound => yes
    procedure :: has_linear_field => linear
    procedure :: bound_change => unknown_change
    procedure :: own_error => no_error
    procedure :: foreign_factor => one
    procedure :: rounding => usual_rounding
    ! what all have
    procedure, non_overridable :: has_displacement
    procedure, non_overridable :: has_whole_field
    procedure, non_overridable :: displacement_source
    procedure, non_overridable :: displacement_text
    procedure, non_overridable :: bound_displacement
    procedure, non_overridable :: with_closed_anchors
    procedure, non_overridable :: complete_shared
    procedure, non_overridable :: shared_mismatch
    procedure, non_overridable :: write_shared
    procedure, non_overridable :: read_shared
    procedure, non_overridable :: write_anchors
    procedure, non_overridable :: read_anchors
  end type compliance_t

  abstract interface
    !> `has_modes`: whether something gives the displacement of the dofs that are not exact. `is_fixed`: whether W is the same at
    !> all points, so that its factors and transforms may be kept.
    pure logical function has_it(self)
      import :: compliance_t
      implicit none(type, external)
      class(compliance_t), intent(in) :: self
    end function has_it

    !> Computes W and q of a point. At an anchor, q is `scale` times the work of the loads on the free motion of this anchor; it is
    !> exactly zero there if it is only rounding beside its terms.
    subroutine evaluate_at(self, theta, point, is_valid)
      import :: compliance_point_t, compliance_t, rk
      implicit none(type, external)
      class(compliance_t), intent(in) :: self
      !> shape (n_terms)
      real(rk), contiguous, intent(in) :: theta(:)
      type(compliance_point_t), intent(inout) :: point
      !> false: elastic constants are impossible at the point; then nothing is computed
      logical, intent(out) :: is_valid
    end subroutine evaluate_at

    !> Returns W [length/force], shape (n_rows, n_rows); without anchors it is symmetric. Requires: evaluate, unless is_fixed.
    function matrix_at(self, point) result(matrix)
      import :: compliance_point_t, compliance_t, rk
      implicit none(type, external)
      class(compliance_t), target, intent(in) :: self
      type(compliance_point_t), target, intent(in) :: point
      real(rk), pointer, contiguous :: matrix(:, :)
    end function matrix_at

    !> Returns for each row the sum of the absolute values [length] of the terms of q, shape (n_rows).
    function terms_at(self, theta, point) result(terms)
      import :: compliance_point_t, compliance_t, rk
      implicit none(type, external)
      class(compliance_t), intent(in) :: self
      real(rk), contiguous, intent(in) :: theta(:)
      type(compliance_point_t), intent(in) :: point
      real(rk), allocatable :: terms(:)
    end function terms_at

    !> Computes the change, to first order, of W z + q for constant z and a given change of the terms. Changes at anchors become
    !> exactly zero where they are only rounding (round_work).
    subroutine change_at(self, point, theta, theta_change, unknowns, changes)
      import :: compliance_point_t, compliance_t, rk
      implicit none(type, external)
      class(compliance_t), intent(in) :: self
      type(compliance_point_t), intent(in) :: point
      !> values of the terms and their changes, shape (n_terms)
      real(rk), contiguous, intent(in) :: theta(:)
      real(rk), contiguous, intent(in) :: theta_change(:)
      !> [force] z, shape (n_rows)
      real(rk), contiguous, intent(in) :: unknowns(:)
      !> [length] shape (n_rows)
      real(rk), contiguous, intent(inout) :: changes(:)
    end subroutine change_at

    !> Computes the derivatives of the displacement of the given dofs with respect to one parameter; NaN for dofs without one.
    subroutine change_field_at(self, answer, gradient, i_parameter, dofs, changes)
      import :: answer_t, compliance_t, gradient_t, rk
      implicit none(type, external)
      class(compliance_t), intent(in) :: self
      !> the answer that was differentiated
      type(answer_t), intent(in) :: answer
      !> with the derivatives of the unknowns, and after complete_gradient
      type(gradient_t), intent(in) :: gradient
      !> number of the parameter, 1-based
      integer, intent(in) :: i_parameter
      !> dofs, 1-based
      integer, intent(in) :: dofs(:)
      !> [length per unit of the parameter] shape (size(dofs))
      real(rk), intent(out) :: changes(:)
    end subroutine change_field_at

    !> `size_of_field` returns the size |u|_K [sqrt(force*length)] of the displacement in the norm of the stiffness. `field_error`
    !> returns a bound of its error in this norm under the same contact forces. In both, rigid motions do not count.
    real(rk) function size_at(self, theta, unknowns, energy, point)
      import :: compliance_point_t, compliance_t, rk
      implicit none(type, external)
      class(compliance_t), intent(in) :: self
      real(rk), contiguous, intent(in) :: theta(:)
      !> [force] z, shape (n_rows)
      real(rk), contiguous, intent(in) :: unknowns(:)
      !> [force*length] z'W z with closed anchors
      real(rk), intent(in) :: energy
      !> after solve_modes
      type(compliance_point_t), intent(in) :: point
    end function size_at
  end interface

contains

  !> Computes everything that does not depend on the point. Requires: complete. This default does nothing.
  subroutine nothing_to_prepare(self)
    class(compliance_t), intent(inout) :: self
  end subroutine nothing_to_prepare

  !> Tries to solve the problem by what is known of the solution at a training point. This default knows nothing. Requires: prepare.
  subroutine not_tried(self, nearest, theta, start, point, solution, workspace, unknowns, is_tried)
    class(compliance_t), intent(in) :: self
    !> number of the training point, 1-based; 0: none
    integer, intent(in) :: nearest
    !> shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    !> active set to start from, shape (n_rows); it may change for a while
    logical, contiguous, intent(inout) :: start(:)
    !> after evaluate
    type(compliance_point_t), intent(inout) :: point
    !> solution%reason < 0: there is no answer, and the unknowns do not change
    type(lcp_solution_t), intent(inout) :: solution
    type(lcp_workspace_t), intent(inout) :: workspace
    !> [force] z, shape (n_rows)
    real(rk), intent(inout) :: unknowns(:)
    !> false: nothing was done
    logical, intent(out) :: is_tried

    is_tried = .false.
  end subroutine not_tried

  !> Allocates the arrays of a point; W has size 0.
  pure subroutine usual_point(self, point)
    class(compliance_t), intent(in) :: self
    type(compliance_point_t), intent(out) :: point

    allocate (point%opening(self%n_rows()), point%rows(self%n_rows()), point%matrix(0, 0))
  end subroutine usual_point

  !> Sets forces that are only rounding to zero (sig_lcp_rounding).
  subroutine drop_small_forces(self, theta, point, unknowns, forces)
    class(compliance_t), intent(in) :: self
    !> shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    !> after evaluate
    type(compliance_point_t), intent(in) :: point
    !> [force] z, shape (n_unknowns)
    real(rk), intent(in) :: unknowns(:)
    !> [force] >= 0, shape (n_rows)
    real(rk), intent(inout) :: forces(:)

    call drop_forces(self%matrix(point), self%opening_terms(theta, point), self%anchors, self%scale, unknowns, forces)
  end subroutine drop_small_forces

  !> Returns the displacement [-] of one dof, perhaps with the sign changed, as each anchor opens by 1; zero if there is no
  !> displacement of this dof, and in this default.
  pure function no_motion(self, dof) result(motion)
    class(compliance_t), intent(in) :: self
    !> 1-based
    integer, intent(in) :: dof
    !> shape (n_anchors)
    real(rk), allocatable :: motion(:)

    allocate (motion(size(self%anchors)), source=0.0_rk)
  end function no_motion

  !> Returns the number of systems W and q. They are tried one after the other, until one gives an answer. This default has one.
  pure integer function one_system(self)
    class(compliance_t), intent(in) :: self

    one_system = 1
  end function one_system

  !> Returns the number of the system that is tried first, 1-based.
  pure integer function first_of_one(self, nearest)
    class(compliance_t), intent(in) :: self
    !> number of the nearest training point, 1-based; 0: none
    integer, intent(in) :: nearest

    first_of_one = 1
  end function first_of_one

  !> Sets the active set to start from: true for each row whose unknown is taken as positive, which means a contact with a force, or
  !> an anchor that is open. It is the set of the nearest training point. Without such a set, it is true for rows that penetrate
  !> without contact forces or, in a problem with anchors, for all rows but the anchors.
  subroutine usual_start(self, nearest, point, start)
    class(compliance_t), intent(in) :: self
    !> number of the training point, 1-based; 0: none
    integer, intent(in) :: nearest
    !> after evaluate
    type(compliance_point_t), intent(in) :: point
    !> shape (n_unknowns)
    logical, allocatable, intent(inout) :: start(:)

    if (nearest >= 1 .and. nearest <= size(self%start_sets, 2)) then
      call unpack_bits(self%start_sets(:, nearest), start)
    else if (size(self%anchors) == 0) then
      start = point%opening < 0
    else
      start = .true.
      start(self%anchors) = .false.
    end if
  end subroutine usual_start

  !> Computes the forces of all rows from the unknowns z. For an anchor the unknown is its opening over `scale` instead of its
  !> force, and w is its force times `scale` instead of its opening. Here all rows are unknowns.
  subroutine take_forces(self, point, opening, unknowns, forces, is_valid)
    class(compliance_t), intent(in) :: self
    !> after evaluate
    type(compliance_point_t), intent(in) :: point
    !> [length] w = W z + q, and [force] z, shape (n_unknowns)
    real(rk), intent(in) :: opening(:)
    real(rk), contiguous, intent(in) :: unknowns(:)
    !> [force] shape (n_rows)
    real(rk), intent(inout) :: forces(:)
    !> false: rows that are no unknowns have the wrong sign, so that this system has no answer
    logical, intent(out) :: is_valid
    integer :: i

    is_valid = .true.
    forces = unknowns
    do i = 1, size(self%anchors)
      associate (row => self%anchors(i))
        forces(row) = merge(0.0_rk, max(0.0_rk, opening(row)) / self%scale, unknowns(row) > 0)
      end associate
    end do
  end subroutine take_forces

  !> Returns the laws of the contacts whose forces are unknowns, from those of all contacts. In this default all are unknowns.
  pure function all_laws(self, laws) result(own)
    class(compliance_t), intent(in) :: self
    type(contact_laws_t), intent(in) :: laws
    type(contact_laws_t) :: own

    own = laws
  end function all_laws

  !> Computes forces and slips of all contacts after a step of a history. This default does nothing, as all rows are unknowns.
  subroutine nothing_to_complete(self, theta, point, answer, is_valid)
    class(compliance_t), intent(in) :: self
    !> shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    !> after evaluate
    type(compliance_point_t), intent(in) :: point
    !> in: the first multipliers, slip and slips are those of the rows, and contacts, that are unknowns; out: those of all. slip and
    !> slips are there only if contacts remember
    type(answer_t), intent(inout) :: answer
    !> false: contacts that are no unknowns break their laws, so that there is no answer
    logical, intent(out) :: is_valid

    is_valid = .true.
  end subroutine nothing_to_complete

  !> Computes the derivatives of the forces of all rows from those of the unknowns, which gradient%multipliers has. This default
  !> does nothing, as all rows are unknowns.
  subroutine nothing_to_expand(self, point, gradient)
    class(compliance_t), intent(in) :: self
    type(compliance_point_t), intent(in) :: point
    type(gradient_t), intent(inout) :: gradient
  end subroutine nothing_to_expand

  !> Returns the number of coordinates of modes in an answer. This default has none: where modes depend on the forces alone, their
  !> coordinates are no part of the answer.
  pure integer function no_coordinates(self)
    class(compliance_t), intent(in) :: self

    no_coordinates = 0
  end function no_coordinates

  !> Computes the coordinates of modes under the answer's forces and, where the forces have no bound, bounds the error of the
  !> displacement. This default does nothing.
  subroutine nothing_to_solve(self, point, answer)
    class(compliance_t), intent(in) :: self
    !> after evaluate
    type(compliance_point_t), intent(inout) :: point
    !> in: theta and unknowns
    type(answer_t), intent(inout) :: answer
  end subroutine nothing_to_solve

  !> Adds derivatives that change_field needs. This default does nothing.
  subroutine nothing_to_add(self, answer, gradient)
    class(compliance_t), intent(in) :: self
    !> the answer that was differentiated
    type(answer_t), intent(in) :: answer
    !> in: derivatives of terms and unknowns
    type(gradient_t), intent(inout) :: gradient
  end subroutine nothing_to_add

  !> Whether own_error is known. This default says yes.
  pure logical function yes(self)
    class(compliance_t), intent(in) :: self

    yes = .true.
  end function yes

  !> Whether the displacement is linear in the terms and in the unknowns, so that size_of_field and field_error hold for changes of
  !> these, too. This default says yes.
  pure logical function linear(self)
    class(compliance_t), intent(in) :: self

    linear = .true.
  end function linear

  !> Bounds the error of the derivative of the displacement with respect to one parameter in the norm of the stiffness, where
  !> has_linear_field is false. This default knows no bound.
  subroutine unknown_change(self, answer, gradient, i_parameter, point, bound, size_of_change)
    class(compliance_t), intent(in) :: self
    !> the answer that was differentiated
    type(answer_t), intent(in) :: answer
    !> after complete_gradient
    type(gradient_t), intent(in) :: gradient
    !> number of the parameter, 1-based
    integer, intent(in) :: i_parameter
    !> after evaluate
    type(compliance_point_t), intent(in) :: point
    !> [sqrt(force*length) per unit of the parameter] no_bound if it is not known, and a lower bound of the size of the derivative
    real(rk), intent(out) :: bound
    real(rk), intent(out) :: size_of_change

    bound = no_bound
    size_of_change = 0
  end subroutine unknown_change

  !> Returns a bound [sqrt(force*length)] of the error |lambda_r - lambda| in the norm of W that errors of W and q cause in the
  !> forces of the problem. This default has no such errors.
  real(rk) function no_error(self, theta, unknowns)
    class(compliance_t), intent(in) :: self
    !> shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    !> [force] z, shape (n_rows); values on anchors do not count
    real(rk), contiguous, intent(in) :: unknowns(:)

    no_error = 0
  end function no_error

  !> Returns the factor [-] between the norm of the true W and that of this W: 1 by default.
  pure real(rk) function one(self)
    class(compliance_t), intent(in) :: self

    one = 1
  end function one

  !> Returns the rounding error [-] that bounds allow for, relative to the size of the answer.
  pure real(rk) function usual_rounding(self)
    class(compliance_t), intent(in) :: self

    usual_rounding = size_rounding
  end function usual_rounding

  !> Whether there is a displacement, perhaps of some dofs only.
  pure logical function has_displacement(self)
    class(compliance_t), intent(in) :: self

    has_displacement = self%has_modes() .or. size(self%exact_dofs) > 0
  end function has_displacement

  !> Whether there is a displacement of all dofs.
  pure logical function has_whole_field(self, n_dofs)
    class(compliance_t), intent(in) :: self
    !> number of dofs of the model
    integer, intent(in) :: n_dofs

    has_whole_field = self%has_modes() .or. size(self%exact_dofs) == n_dofs
  end function has_whole_field

  !> Returns the source of a dof's displacement: displacement_exact, displacement_by_modes or displacement_none.
  pure integer function displacement_source(self, dof) result(source)
    class(compliance_t), intent(in) :: self
    !> 1-based
    integer, intent(in) :: dof

    source = merge(displacement_by_modes, displacement_none, self%has_modes())
    if (place_in_ascending(self%exact_dofs, dof) > 0) source = displacement_exact
  end function displacement_source

  !> Returns a text that says at which nodes there are displacements, and how they are found. It has no line end.
  pure function displacement_text(self, elsewhere) result(text)
    class(compliance_t), intent(in) :: self
    !> how the displacement of dofs that are not exact is found, such as `by 12 modes`; empty if there is none
    character(*), intent(in) :: elsewhere
    character(:), allocatable :: text

    text = 'none: contact forces only'
    if (size(self%exact_boundaries) > 0) then
      text = 'exact at the nodes of ' // join(self%exact_boundaries, ', ')
    else if (size(self%exact_dofs) > 0) then
      text = 'exact at all nodes'
    end if
    if (elsewhere /= '' .and. size(self%exact_dofs) > 0) then
      text = text // ', ' // elsewhere // ' elsewhere'
    else if (elsewhere /= '') then
      text = elsewhere
    else if (size(self%exact_boundaries) > 0) then
      text = text // ', none elsewhere'
    end if
  end function displacement_text

  !> Sets displacement_bound and relative_displacement_bound from the bound of the forces. Rigid motions do not count.
  subroutine bound_displacement(self, bound_of_forces, unknowns, energy, point, answer)
    class(compliance_t), intent(in) :: self
    !> [sqrt(force*length)]
    real(rk), intent(in) :: bound_of_forces
    !> [force] z, shape (n_unknowns)
    real(rk), contiguous, intent(in) :: unknowns(:)
    !> [force*length] z'W z: openings of anchors do not count in it, as their rows and columns of W have opposite signs
    real(rk), intent(in) :: energy
    type(compliance_point_t), intent(in) :: point
    !> in: theta
    type(answer_t), intent(inout) :: answer
    real(rk) :: size_of_field

    size_of_field = comparable_size(self%size_of_field(answer%theta, unknowns, max(0.0_rk, energy), point), self%largest_field)
    call answer%take_displacement_bound(bound_of_forces + self%rounding() * size_of_field + &
      self%field_error(answer%theta, unknowns, max(0.0_rk, energy), point), size_of_field)
  end subroutine bound_displacement

  !> Returns a copy of forces or unknowns with zeros at the anchors.
  pure function with_closed_anchors(self, values) result(closed)
    class(compliance_t), intent(in) :: self
    !> [force] shape (n_rows)
    real(rk), intent(in) :: values(:)
    real(rk) :: closed(size(values))

    closed = values
    closed(self%anchors) = 0
  end function with_closed_anchors

  !> Sets changes of the work of the loads on the motions of the anchors to zero if they are rounding beside their terms, which are
  !> differences.
  pure subroutine round_work(anchors, terms, changes)
    !> 1-based among the rows
    integer, intent(in) :: anchors(:)
    !> sum of the absolute values of the terms of the change at each anchor, shape (n_anchors)
    real(rk), intent(in) :: terms(:)
    !> change of W z + q, shape (n_rows)
    real(rk), intent(inout) :: changes(:)
    integer :: i

    do i = 1, size(anchors)
      if (abs(changes(anchors(i))) <= rounding_of_data * terms(i)) changes(anchors(i)) = 0
    end do
  end subroutine round_work

  !> Allocates with size 0 each array of this type that is not allocated.
  pure subroutine complete_shared(self, sizes)
    class(compliance_t), intent(inout) :: self
    type(model_sizes_t), intent(in) :: sizes

    call fill_missing(self%start_sets, n_words(sizes%n_multipliers))
    call fill_missing(self%exact_dofs)
    call fill_missing(self%exact_boundaries)
    call fill_missing(self%anchors)
  end subroutine complete_shared

  !> Returns the name of an array of this type whose shape or values do not fit the model; empty when all fit. A scale that is not
  !> positive gives `anchors`. Requires: complete_shared.
  pure function shared_mismatch(self, sizes) result(name)
    class(compliance_t), intent(in) :: self
    type(model_sizes_t), intent(in) :: sizes
    character(:), allocatable :: name

    name = ''
    if (.not. (are_indices(self%exact_dofs, sizes%n_dofs) .and. is_ascending(self%exact_dofs))) name = 'exact_dofs'
    if (size(self%start_sets, 1) /= n_words(sizes%n_multipliers)) name = 'start_sets'
    if (size(self%start_sets, 2) > 0 .and. size(self%start_sets, 2) /= sizes%n_points) name = 'start_sets'
    if (.not. (are_indices(self%anchors, sizes%n_multipliers) .and. self%scale > 0)) name = 'anchors'
  end function shared_mismatch

  !> Writes the arrays of this type to a group of a model file. A failure of the file is reported when the file is closed.
  subroutine write_shared(self, file, group, length, force)
    class(compliance_t), intent(in) :: self
    type(h5_writer_t), intent(inout) :: file
    character(*), intent(in) :: group
    !> names of the units
    character(*), intent(in) :: length
    character(*), intent(in) :: force

    call file%write(group // '/exact_dofs', self%exact_dofs, description='dofs whose displacement is exact, 1-based')
    call file%write(group // '/exact_boundaries', self%exact_boundaries, description= &
      'boundaries that have these dofs; empty: the dofs are those of all nodes, or there are none')
    call file%write(group // '/start_sets', self%start_sets, description= &
      'active contacts (of anchors: open ones) at each training point, a bit per contact, 32 to an integer, a point per row')
    call file%write(group // '/largest_field', self%largest_field, 'sqrt(' // force // '*' // length // ')', &
      'largest size of the displacement in training, in the norm of the stiffness')
  end subroutine write_shared

  !> Writes what belongs to anchors, and the size of the forces (write_shared).
  subroutine write_anchors(self, file, group, length, force)
    class(compliance_t), intent(in) :: self
    type(h5_writer_t), intent(inout) :: file
    character(*), intent(in) :: group
    character(*), intent(in) :: length
    character(*), intent(in) :: force

    call file%write(group // '/anchors', self%anchors, description='contacts that hold bodies which nothing else holds, 1-based')
    call file%write(group // '/scale', self%scale, length // '/(' // force // ')', &
      'the unknown of an anchor is its opening over this scale, not its force; its row gives force times scale, not its opening')
    call file%write(group // '/least_eigenvalue', self%least_eigenvalue, length // '/(' // force // ')', &
      'at most the smallest eigenvalue of the compliance without anchors; 0: not known')
    call file%write(group // '/largest_size', self%largest_size, 'sqrt(' // force // '*' // length // ')', &
      'largest size of the contact forces in training, in the norm of the compliance')
  end subroutine write_anchors

  !> Reads the arrays of this type from a group of a model file. Errors: a dataset is missing, or has another type or rank.
  subroutine read_shared(self, file, group, error)
    class(compliance_t), intent(inout) :: self
    type(h5_reader_t), intent(in) :: file
    character(*), intent(in) :: group
    type(error_t), allocatable, intent(inout) :: error

    call file%read(group // '/exact_dofs', self%exact_dofs, error)
    call file%read(group // '/exact_boundaries', self%exact_boundaries, error)
    call file%read(group // '/start_sets', self%start_sets, error)
    call file%read(group // '/largest_field', self%largest_field, error)
  end subroutine read_shared

  !> Reads what write_anchors writes (read_shared).
  subroutine read_anchors(self, file, group, error)
    class(compliance_t), intent(inout) :: self
    type(h5_reader_t), intent(in) :: file
    character(*), intent(in) :: group
    type(error_t), allocatable, intent(inout) :: error

    call file%read(group // '/anchors', self%anchors, error)
    call file%read(group // '/scale', self%scale, error)
    ! earlier versions do not have it
    if (file%has(group // '/least_eigenvalue')) call file%read(group // '/least_eigenvalue', self%least_eigenvalue, error)
    call file%read(group // '/largest_size', self%largest_size, error)
  end subroutine read_anchors
end module sig_compliance
