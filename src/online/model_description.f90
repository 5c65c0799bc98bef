! SPDX-License-Identifier: BSD-3-Clause
!> The text of `signorom describe` about a model.
module sig_model_description
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  use sig_description_line, only: eol, line
  use sig_kinds, only: rk
  use sig_model, only: model_t
  use sig_text, only: counted, short_number, to_text
  implicit none(type, external)
  private
  public :: describe_model

contains

  !> Returns the text that `signorom describe` prints, as lines; the last line has no line end. Requires: complete_model
  !> or read_model.
  pure function describe_model(model) result(text)
    type(model_t), intent(in) :: model
    character(:), allocatable :: text
    integer :: i

    text = model%title // eol // eol // parameter_lines(model) // eol // size_lines(model) // eol
    do i = 1, model%n_clusters()
      text = text // cluster_lines(model, i) // eol
    end do
    text = text // fallback_lines(model) // eol // validation_lines(model) // eol // &
      line('written by', 'signorom ' // model%code_version // ', model format ' // to_text(model%format_version)) // &
      line('mesh', model%mesh_hash) // 'provenance' // repeat(' ', 14) // model%provenance
  end function describe_model

  pure function parameter_lines(model) result(text)
    type(model_t), intent(in) :: model
    character(:), allocatable :: text
    integer :: i

    text = 'parameters, and the box in which the model was trained' // eol
    do i = 1, size(model%parameter_names)
      text = text // line('  ' // model%parameter_names(i)%text, short_number(model%box(1, i)) // ' to ' // &
        short_number(model%box(2, i)) // &
        ' ' // model%parameter_units(i)%text)
    end do
    if (model%history%is_there()) text = text // line('history', counted(model%history%n_times(), 'time') // ' from ' // &
      short_number(model%history%times(1)) // ' to ' // short_number(model%history%times(model%history%n_times())) // ' ' // &
      model%history%unit)
    text = text // line('training points', to_text(size(model%training_points, 2))) // choice_line(model)
  end function parameter_lines

  !> Returns the line, with its end, that tells how many clusters there are and how one is chosen; empty for one cluster.
  pure function choice_line(model) result(text)
    type(model_t), intent(in) :: model
    character(:), allocatable :: text

    text = ''
    if (model%n_clusters() == 1) return
    text = line('clusters', to_text(model%n_clusters()) // '; the cell of the training grid chooses the one that answers a point')
    if (.not. allocated(model%choice%labels)) text = line('clusters', to_text(model%n_clusters()) // &
      '; a random forest chooses the one that answers a point')
  end function choice_line

  pure function size_lines(model) result(text)
    type(model_t), intent(in) :: model
    character(:), allocatable :: text

    text = line('full-order model', counted(model%n_nodes, 'node') // ', ' // counted(model%n_dofs, 'dof') // ', ' // &
      counted(model%n_multipliers, 'contact row')) // contact_lines(model) // &
      line('units', 'displacements in ' // model%length_unit // ', contact forces in ' // model%force_unit) // &
      line('terms of the equations', to_text(model%terms%n_terms()))
    ! a model that is exact has no POD
    if (.not. model%parts(1)%reduced%is_exact()) text = text // line('POD tolerance', short_number(model%pod_tolerance))
    text = text // line('prescribed values', model%dirichlet)
  end function size_lines

  !> Returns a line, with its end, for each entry of the deck's contact section: the number that `predict` gives it, its surfaces
  !> or its surface and obstacle, and its number of contact rows; empty for a model from an older file.
  pure function contact_lines(model) result(text)
    type(model_t), intent(in) :: model
    character(:), allocatable :: text
    integer :: i

    text = ''
    do i = 1, model%resultants%n_entries()
      text = text // line('  contact ' // to_text(i), model%resultants%names(i)%text // ', ' // &
        counted(count(model%resultants%entries == i), 'contact row'))
    end do
  end function contact_lines

  pure function cluster_lines(model, i) result(text)
    type(model_t), intent(in) :: model
    integer, intent(in) :: i
    character(:), allocatable :: text

    associate (part => model%parts(i)%reduced)
      text = 'reduced model (' // part%kind() // ')'
      if (model%n_clusters() > 1) text = text // ' of cluster ' // to_text(i)
      text = text // eol
      if (model%n_clusters() > 1) text = text // line('  training points', to_text(size(part%training_points())))
      text = text // part%describe()
    end associate
  end function cluster_lines

  pure function fallback_lines(model) result(text)
    type(model_t), intent(in) :: model
    character(:), allocatable :: text
    integer :: i

    ! the index is a variable, because gfortran 12 does not evaluate a function in this place
    i = model%fallback()
    if (i == 0) then
      text = ''
      if (.not. model%parts(1)%reduced%is_exact()) text = line('without a solution', &
        'a point where the reduced problem has none gets no answer')
    else if (model%parts(i)%reduced%has_displacement()) then
      text = line('without a solution', 'the full-order model answers (forces and displacements)')
    else
      text = line('without a solution', 'the full-order model answers (forces; displacements by the reduced basis)')
    end if
  end function fallback_lines

  pure function validation_lines(model) result(text)
    type(model_t), intent(in) :: model
    character(:), allocatable :: text
    integer :: i

    associate (validation => model%validation)
      text = line('validation', 'none yet: signorom validate DECK measures the errors')
      if (size(validation%names) == 0) return
      text = line('validation', 'median        95 %          largest')
      do i = 1, size(validation%names)
        ! a model without a bound of energies has no errors of them, either
        if (ieee_is_nan(validation%maximum(i))) cycle
        text = text // line('  ' // validation%names(i)%text, padded(validation%median(i)) // padded(validation%p95(i)) // &
          short_number(validation%maximum(i)))
      end do
      text = text // line('verdict', validation%verdict)
      do i = 1, size(validation%method_names)
        if (validation%method_counts(i) == 0) cycle
        text = text // line('  by ' // validation%method_names(i)%text, counted(validation%method_counts(i), 'point'))
      end do
    end associate
  end function validation_lines

  pure function padded(value) result(text)
    real(rk), intent(in) :: value
    character(14) :: text

    text = short_number(value)
  end function padded
end module sig_model_description
