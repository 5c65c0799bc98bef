! SPDX-License-Identifier: BSD-3-Clause
!> Columns of contact forces in the tables of predict and of histories.
module sig_force_columns
  use sig_kinds, only: rk
  use sig_model, only: model_t
  use sig_text, only: join, to_text
  implicit none(type, external)
  private
  public :: force_columns, force_values

contains

  !> Returns the names of the columns, with commas between them: n_active, contact_force (the sum over all rows), those of
  !> contact_columns, and lambda_<number>, the normal force of each contact; with friction also tau_<number> in the plane, or
  !> tau_<number>_1 and tau_<number>_2 in space, the tangential forces on the second side. The number is that of the contact's owner
  !> (its first node) in the mesh file.
  function force_columns(model) result(text)
    !> its header is used, not its parts
    type(model_t), intent(in) :: model
    character(:), allocatable :: text
    integer :: i, k

    text = 'n_active,contact_force' // contact_columns(model)
    do k = 1, model%laws%n_contacts
      text = text // ',lambda_' // to_text(model%first_side%owner_tag(k))
    end do
    do k = 1, model%laws%n_contacts
      do i = 1, model%laws%n_tangents(k)
        text = text // ',tau_' // to_text(model%first_side%owner_tag(k))
        if (model%n_dim == 3) text = text // '_' // to_text(model%laws%directions(i, k))
      end do
    end do
  end function force_columns

  !> Returns the values of force_columns, with commas between them; `nan` each without an answer.
  function force_values(model, multipliers, slip, slips, has_answer) result(text)
    type(model_t), intent(in) :: model
    !> [force] of all rows, shape (n_multipliers)
    real(rk), intent(in) :: multipliers(:)
    !> [length] slip since the last time in tangential rows, shape (n_multipliers); without friction not used
    real(rk), intent(in) :: slip(:)
    !> whether each contact slips, shape (n_contacts); without friction not used
    logical, intent(in) :: slips(:)
    logical, intent(in) :: has_answer
    character(:), allocatable :: text
    integer :: k

    if (has_answer) then
      associate (normal => multipliers(:model%laws%n_contacts))
        text = to_text(count(model%laws%are_closed(multipliers))) // ',' // to_text(sum(normal)) // &
          contact_values(model, multipliers, slip, slips, .true.)
      end associate
      do k = 1, size(multipliers)
        text = text // ',' // to_text(multipliers(k))
      end do
    else
      text = 'nan,nan' // contact_values(model, multipliers, slip, slips, .false.) // repeat(',nan', size(multipliers))
    end if
  end function force_values

  !> Returns the column names of each contact of the deck (`contact_<i>_...`), each after a comma: area, force (one per axis),
  !> moment, and moment_imbalance, the sum of the moments of both sides. A moment has one column in the plane and one per axis in
  !> space. Forces and moments sum normal forces and friction. A contact with friction also has slip_share, the share of its area
  !> that slips, and dissipation, the work of friction since the last time. A model from an older file, which does not name its
  !> contacts, has none of these columns.
  function contact_columns(model) result(text)
    type(model_t), intent(in) :: model
    character(:), allocatable :: text
    integer :: i, i_axis

    text = ''
    associate (axes => model%terms%coordinate_names)
      do i = 1, model%resultants%n_entries()
        text = text // ',contact_' // to_text(i) // '_area'
        do i_axis = 1, model%n_dim
          text = text // ',contact_' // to_text(i) // '_force_' // axes(i_axis)%text
        end do
        text = text // moment_columns('_moment') // moment_columns('_moment_imbalance')
        if (model%resultants%has_friction(model%laws, i)) text = text // ',contact_' // to_text(i) // '_slip_share,contact_' // &
          to_text(i) // '_dissipation'
      end do
    end associate

  contains

    !> Returns the column names of a moment: one in the plane, one per axis in space.
    function moment_columns(name) result(columns)
      character(*), intent(in) :: name
      character(:), allocatable :: columns
      integer :: j

      columns = ''
      if (model%resultants%n_moments() == 1) columns = ',contact_' // to_text(i) // name
      do j = 1, merge(model%n_dim, 0, model%resultants%n_moments() == model%n_dim)
        columns = columns // ',contact_' // to_text(i) // name // '_' // model%terms%coordinate_names(j)%text
      end do
    end function moment_columns
  end function contact_columns

  !> Returns the values of the columns of contact_columns, each after a comma; `nan` without an answer.
  function contact_values(model, multipliers, slip, slips, has_answer) result(text)
    type(model_t), intent(in) :: model
    !> as in force_values
    real(rk), intent(in) :: multipliers(:)
    real(rk), intent(in) :: slip(:)
    logical, intent(in) :: slips(:)
    logical, intent(in) :: has_answer
    character(:), allocatable :: text
    real(rk) :: areas(model%resultants%n_entries()), forces(model%n_dim, size(areas))
    real(rk), dimension(model%resultants%n_moments(), size(areas)) :: imbalances, moments
    real(rk), dimension(size(areas)) :: dissipations, shares
    real(rk), allocatable :: values(:)
    integer :: k

    text = ''
    call model%resultants%evaluate(model%laws, model%areas, multipliers, areas, forces, moments)
    imbalances = model%resultants%imbalances(multipliers)
    if (model%laws%remembers()) then
      shares = model%resultants%slip_shares(model%laws, model%areas, multipliers, slips)
      dissipations = model%resultants%dissipations(multipliers, slip)
    end if
    do k = 1, size(areas)
      values = [areas(k), forces(:, k), moments(:, k), imbalances(:, k)]
      if (model%resultants%has_friction(model%laws, k)) values = [values, shares(k), dissipations(k)]
      if (has_answer) then
        text = text // ',' // join(values, ',')
      else
        text = text // repeat(',nan', size(values))
      end if
    end do
  end function contact_values
end module sig_force_columns
