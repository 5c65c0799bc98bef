! SPDX-License-Identifier: BSD-3-Clause
!> Warnings that results may be inaccurate or not what the user wants: of the deck before anything is solved, of contacts that never
!> close, of residuals and errors afterwards.
module sig_accuracy_warnings
  use sig_contact_rows, only: contact_rows_t
  use sig_contact_summary, only: contact_name
  use sig_deck_config, only: deck_config_t
  use sig_element_types, only: element_types
  use sig_history, only: history_t
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t
  use sig_statistics, only: statistics_t, summarize
  use sig_text, only: append_text, lost_digits, read_real, short_number, string_t, to_text
  implicit none(type, external)
  private
  public :: deck_warnings, open_contact_warnings, equilibrium_warning, motion_warning
  public :: error_warnings, accuracy_advice, field_advice

  !> [-] linear elements lock beyond this Poisson's ratio: they cannot change their shape at constant volume
  real(rk), parameter :: locking_ratio = 0.49_rk
  !> [-] of Young's moduli: half of the digits are left to the softest material
  real(rk), parameter :: largest_contrast = 1.0e8_rk
  !> [-] residual of equilibrium over the forces: a direct solver leaves 1e-16 to 1e-12
  real(rk), parameter :: largest_residual = 1.0e-6_rk

  !> [rad] rotations above it are not small: in linear equations a body that rotates grows by half of the square of the rotation
  real(rk), parameter :: largest_small_rotation = 0.1_rk
  !> [-] deformations above it are far from small: often a unit is wrong. The half disks of the paper have 0.26
  real(rk), parameter :: largest_small_deformation = 0.3_rk

  !> [-] displacements that differ by more while contact forces and strains differ by less are not unique
  real(rk), parameter :: loose_displacement = 0.5_rk, same_answer = 1.0e-3_rk

  !> errors of validation.csv with a warning of their own, and its limits
  character(*), parameter :: judged_names(2) = [character(12) :: 'e_lambda_rid', 'e_lambda_all']
  real(rk), parameter :: largest_median = 0.1_rk, largest_p95 = 0.5_rk

contains

  !> Returns the warnings of a deck: of its parameters, then of its materials. Empty without warnings.
  pure function deck_warnings(deck, mesh, material_of_cell) result(warnings)
    type(deck_config_t), intent(in) :: deck
    type(mesh_t), intent(in) :: mesh
    !> as for add_material_warnings
    integer, intent(in) :: material_of_cell(:)
    type(string_t), allocatable :: warnings(:)

    allocate (warnings(0))
    call add_unused_warnings(deck, warnings)
    call add_table_warnings(deck%history%states, warnings)
    call add_material_warnings(deck, mesh, material_of_cell, warnings)
  end function deck_warnings

  !> Appends a warning for each parameter and each table whose name no expression of the deck has.
  pure subroutine add_unused_warnings(deck, warnings)
    type(deck_config_t), intent(in) :: deck
    type(string_t), allocatable, intent(inout) :: warnings(:)
    integer :: i

    do i = 1, size(deck%state_parameters)
      if (.not. deck%state_parameters(i)%is_used) call append_text(warnings, 'no expression of the deck uses the ' // &
        trim(merge('parameter', 'table    ', i <= size(deck%parameters))) // ' ''' // deck%state_parameters(i)%name // &
        ''': its value changes nothing')
    end do
  end subroutine add_unused_warnings

  !> Appends a warning for each table with a number as its last time if steps go further.
  pure subroutine add_table_warnings(history, warnings)
    type(history_t), intent(in) :: history
    type(string_t), allocatable, intent(inout) :: warnings(:)
    real(rk) :: last
    integer :: i
    logical :: is_number

    if (.not. history%is_there()) return
    do i = 1, size(history%tables)
      associate (table => history%tables(i))
        call read_real(table%times(size(table%times))%text, last, is_number)
        if (.not. is_number .or. history%times(history%n_times()) <= last) cycle
        call append_text(warnings, 'the steps go to the time ' // short_number(history%times(history%n_times())) // &
          ', and the table ''' // table%name // ''' ends at ' // short_number(last) // ': from there on it keeps its last value')
      end associate
    end do
  end subroutine add_table_warnings

  !> Returns a warning for each contact entry that is open at all points, that is, that has rows and no multiplier above 0. Empty
  !> without warnings.
  pure function open_contact_warnings(deck, rows, multipliers) result(warnings)
    type(deck_config_t), intent(in) :: deck
    type(contact_rows_t), intent(in) :: rows
    !> [force] normal forces, then others; shape (at least n_rows, n_points)
    real(rk), intent(in) :: multipliers(:, :)
    type(string_t), allocatable :: warnings(:)
    integer :: i

    allocate (warnings(0))
    do i = 1, size(deck%contact)
      associate (is_own => rows%contact_entry == i)
        if (.not. any(is_own) .or. any(spread(is_own, 2, size(multipliers, 2)) .and. &
          multipliers(:rows%n_rows, :) > 0)) cycle
        call append_text(warnings, 'contact[' // to_text(i) // '] (' // contact_name(deck, i) // ') is open at all ' // &
          to_text(size(multipliers, 2)) // ' training points, so it has no force there; if it should close, look at the gaps ' // &
          '(signorom check prints them), the directions of the loads, and the ranges of the parameters')
      end associate
    end do
  end function open_contact_warnings

  !> Appends warnings of materials that make the equations (3) inaccurate: one for each material with a Poisson's ratio above 0.49
  !> and at least one linear element (not in plane stress), and one if the largest Young's modulus of all materials is more than 1e8
  !> times the smallest. Values that depend on the parameters are not looked at.
  pure subroutine add_material_warnings(deck, mesh, material_of_cell, warnings)
    type(deck_config_t), intent(in) :: deck
    type(mesh_t), intent(in) :: mesh
    !> index in deck%materials of each cell of the whole mesh, shape (n_cells)
    integer, intent(in) :: material_of_cell(:)
    type(string_t), allocatable, intent(inout) :: warnings(:)
    real(rk) :: smallest, largest
    integer :: i

    smallest = huge(smallest)
    largest = 0
    do i = 1, size(deck%materials)
      associate (e => deck%materials(i)%young_modulus, nu => deck%materials(i)%poisson_ratio)
        if (e%is_constant) smallest = min(smallest, e%constant)
        if (e%is_constant) largest = max(largest, e%constant)
        if (deck%mesh%model == 'plane_stress' .or. .not. nu%is_constant) cycle
        if (.not. any(element_types(mesh%cell_types)%order == 1 .and. material_of_cell == i)) cycle
        if (nu%constant > locking_ratio) call append_text(warnings, 'materials.' // deck%materials(i)%name // &
          '.poisson_ratio is ' // to_text(nu%constant) // ': linear elements are too stiff above ' // to_text(locking_ratio) // &
          ' (volumetric locking), and their displacements and forces may be wrong by tens of percent; take quadratic elements')
      end associate
    end do
    if (largest > largest_contrast * smallest) call append_text(warnings, 'the largest Young''s modulus is ' // &
      short_number(largest / smallest) // ' times the smallest: answers may lose about ' // &
      lost_digits(largest / smallest) // '; above ' // &
      short_number(largest_contrast) // ' replace the stiff body by an obstacle or by prescribed displacements, and look at ' // &
      'the residuals in the report')
  end subroutine add_material_warnings

  !> Returns a warning if a residual of the full-order solutions is above 1e-6 or not a number, that is, if (3) does not hold
  !> accurately; empty otherwise.
  pure function equilibrium_warning(residuals) result(warning)
    !> [-] residual of equilibrium relative to the forces, of each solution
    real(rk), intent(in) :: residuals(:)
    character(:), allocatable :: warning

    warning = ''
    if (size(residuals) == 0) return
    if (all(residuals <= largest_residual)) return
    warning = 'the full-order solutions miss equilibrium by up to ' // short_number(maxval(residuals)) // &
      ' of the forces (limit ' // short_number(largest_residual) // '): the stiffness may be ill-conditioned; look at ' // &
      'materials of very different stiffness and at flat elements'
  end function equilibrium_warning

  !> Returns the text of rotation_warning, or if that is empty, of deformation_warning.
  pure function motion_warning(rotation, deformation) result(warning)
    !> as for these
    real(rk), intent(in) :: rotation
    real(rk), intent(in) :: deformation
    character(:), allocatable :: warning

    warning = rotation_warning(rotation)
    if (warning == '') warning = deformation_warning(deformation)
  end function motion_warning

  !> Returns a warning if the rotation of a body that only contact holds is above 0.1 rad; empty otherwise.
  pure function rotation_warning(rotation) result(warning)
    !> [rad] result of largest_rotation: the largest rotation of such a body in any solution, 0 without such bodies
    real(rk), intent(in) :: rotation
    character(:), allocatable :: warning

    warning = ''
    if (.not. rotation > largest_small_rotation) return
    warning = 'a body that only contact holds rotates by up to ' // short_number(rotation) // ' rad; the equations are right ' // &
      'for small rotations only (up to about ' // short_number(largest_small_rotation) // ' rad), so displacements and ' // &
      'contact forces are wrong there: look at the units, and hold the body if a load turns it (as a lever on a pin)'
  end function rotation_warning

  !> Returns a warning if a body deforms by more than 0.3 of its size; empty otherwise.
  pure function deformation_warning(deformation) result(warning)
    !> [-] result of largest_deformation
    real(rk), intent(in) :: deformation
    character(:), allocatable :: warning

    warning = ''
    if (.not. deformation > largest_small_deformation) return
    warning = 'displacements within a body differ by up to ' // short_number(100 * deformation) // ' % of its size; the ' // &
      'equations are right for small displacements only: see whether lengths, loads, gaps and moduli have the right units'
  end function deformation_warning

  !> Returns warnings of errors of a model: loose_warning, where that has a text, then at most one for each of e_lambda_rid and
  !> e_lambda_all: that the error has no value at any point; else that its median is above largest_median; else that its 95 %
  !> quantile is above largest_p95. Errors of fields have no warning here: the verdict speaks of them. Empty without warnings.
  pure function error_warnings(kind, names, errors) result(warnings)
    !> kind of the model, for accuracy_advice
    character(*), intent(in) :: kind
    !> names of the errors, as in validation.csv; if one that is judged is missing, there is no warning of it
    character(*), intent(in) :: names(:)
    !> [-] NaN (not measured) values do not count, infinite ones do; shape (size(names), n_points)
    real(rk), intent(in) :: errors(:, :)
    type(string_t), allocatable :: warnings(:)
    type(statistics_t) :: statistics
    integer :: i, i_error

    allocate (warnings(0))
    if (loose_warning(names, errors) /= '') call append_text(warnings, loose_warning(names, errors))
    do i = 1, size(judged_names)
      i_error = findloc(names == judged_names(i), .true., dim=1)
      if (i_error == 0) cycle
      statistics = summarize(errors(i_error, :))
      if (statistics%n_values == 0) then
        call append_text(warnings, trim(judged_names(i)) // ' could not be measured: it has no value at any of the ' // &
          to_text(size(errors, 2)) // ' test points (no contact there, no full-order solution, or no answer)')
      else if (statistics%median > largest_median) then
        call append_text(warnings, large_error(kind, judged_names(i), 'median', statistics%median, largest_median))
      else if (statistics%p95 > largest_p95) then
        call append_text(warnings, large_error(kind, judged_names(i), '95 % quantile', statistics%p95, largest_p95))
      end if
    end do
  end function error_warnings

  !> Returns a warning if displacements differ by more than half at some point while contact forces and strains agree at all points:
  !> two answers that are both right, as of a disc on a plane, which may roll. Empty otherwise.
  pure function loose_warning(names, errors) result(warning)
    !> as for error_warnings
    character(*), intent(in) :: names(:)
    real(rk), intent(in) :: errors(:, :)
    character(:), allocatable :: warning
    real(rk) :: largest

    warning = ''
    largest = largest_error(names, errors, 'e_u')
    if (.not. largest > loose_displacement) return
    if (largest_error(names, errors, 'e_lambda_all') > same_answer) return
    if (largest_error(names, errors, 'e_u_energy_relative') > same_answer) return
    warning = 'displacements are not unique at some test points: e_u is up to ' // short_number(largest) // &
      ', but the contact forces and the strains agree; a body that only contact holds can move there at nearly no force, so ' // &
      'hold it if its place matters'
  end function loose_warning

  !> Returns the largest value of one error at all points; 0 if no point has one, or if its name is missing.
  pure real(rk) function largest_error(names, errors, name) result(largest)
    !> as for error_warnings
    character(*), intent(in) :: names(:)
    real(rk), intent(in) :: errors(:, :)
    character(*), intent(in) :: name
    type(statistics_t) :: statistics
    integer :: i

    largest = 0
    i = findloc(names == name, .true., dim=1)
    if (i == 0) return
    statistics = summarize(errors(i, :))
    largest = statistics%maximum
  end function largest_error

  !> Returns the warning of an error that is above its limit, with accuracy_advice for this kind of model. The caller has compared
  !> the value with the limit.
  pure function large_error(kind, name, statistic, value, limit) result(text)
    character(*), intent(in) :: kind
    !> of the error, such as e_u
    character(*), intent(in) :: name
    !> in words: median or 95 % quantile
    character(*), intent(in) :: statistic
    !> [-] of the statistic
    real(rk), intent(in) :: value
    real(rk), intent(in) :: limit
    character(:), allocatable :: text

    text = 'the model is inaccurate: the ' // statistic // ' of ' // trim(name) // ' is ' // short_number(value) // ' (limit ' // &
      to_text(limit) // '); ' // accuracy_advice(kind)
  end function large_error

  !> Returns the last part of a sentence: what makes the contact forces of a model of the kind hhr or interpolated more accurate;
  !> for the other kinds, where to look for the cause of large errors, and when more training points help.
  pure function accuracy_advice(kind) result(text)
    !> name of a kind of reduced models: condensed, hhr, inelastic, interpolated or tied
    character(*), intent(in) :: kind
    character(:), allocatable :: text

    select case (kind)
    case ('hhr')
      text = 'take reduction.method: condensed, more training points, or a smaller reduction.pod_tolerance'
    case ('inelastic')
      text = 'take more training histories, best by training: {greedy: ...}, or a smaller reduction.inelastic_tolerance'
    case ('interpolated')
      text = 'take a smaller reduction.stiffness_tolerance, or more training points'
    case default
      text = 'the contact forces of such a model have only rounding errors where it has an answer and the full-order ' // &
        'solutions are accurate: look at ''warnings'' and ''residuals'' in report.yaml; more training points help a tied ' // &
        'model that lacks answers'
    end select
  end function accuracy_advice

  !> Returns the last part of a sentence: what makes the displacements of a model more accurate.
  pure function field_advice(kind) result(text)
    !> as for accuracy_advice
    character(*), intent(in) :: kind
    character(:), allocatable :: text

    text = 'take more training points, or a larger reduction.max_full_order_size, which leaves room for exact displacements'
    if (any(kind == [character(9) :: 'hhr', 'inelastic'])) text = accuracy_advice(kind)
    if (kind == 'condensed') text = 'take reduction.displacement_tolerance: 0, which keeps all responses as they are if ' // &
      'reduction.max_full_order_size allows it'
    if (kind == 'interpolated') text = 'take a smaller reduction.displacement_tolerance, or 0, which interpolates the ' // &
      'displacements of bodies with several varying constants, too, if reduction.max_full_order_size allows it, but without a ' // &
      'known error'
  end function field_advice
end module sig_accuracy_warnings
