! SPDX-License-Identifier: BSD-3-Clause
!> The table of mechanical models: plane strain, plane stress, axisymmetric and solid. The code reads the properties of a model from
!> its row.
module sig_mechanical_models
  use sig_kinds, only: rk
  use sig_text, only: append_text, string_t
  implicit none(type, external)
  private
  public :: mechanical_model_t, mechanical_models, mechanical_model
  public :: circumference, components_text, coordinate_names, is_plane

  !> One row of the table. Tensor components are numbered as in VTK: xx, yy, zz, xy, yz, xz. In axisymmetry x = r, y = z, and zz is
  !> the hoop direction.
  type :: mechanical_model_t
    character(12) :: name = ''
    !> dimension of the mesh
    integer :: n_dim = 0
    !> names of the coordinates and of the displacement components in the deck
    character(1) :: axes(3) = ' '
    !> whether the body is the mesh turned around the axis x = 0
    logical :: is_round = .false.
    !> whether the stress sigma_zz is zero (plane stress); otherwise total strains (elastic plus imposed) that are not in `strains`
    !> are zero
    logical :: is_thin = .false.
    !> number of strain components that do work, and their numbers in the tensor
    integer :: n_strains = 0
    integer :: strains(6) = 0
    !> names in the deck of the strain components that can be imposed, shape (6); blank: cannot be imposed
    character(4) :: strain_names(6) = ' '
  end type mechanical_model_t

  !> the table
  type(mechanical_model_t), parameter :: mechanical_models(4) = [ &
    mechanical_model_t('plane_strain', 2, ['x', 'y', ' '], .false., .false., 3, [1, 2, 4, 0, 0, 0], &
    [character(4) :: 'xx', 'yy', 'zz', 'xy', '', '']), &
    mechanical_model_t('plane_stress', 2, ['x', 'y', ' '], .false., .true., 3, [1, 2, 4, 0, 0, 0], &
    [character(4) :: 'xx', 'yy', '', 'xy', '', '']), &
    mechanical_model_t('axisymmetric', 2, ['r', 'z', ' '], .true., .false., 4, [1, 2, 3, 4, 0, 0], &
    [character(4) :: 'rr', 'zz', 'hoop', 'rz', '', '']), &
    mechanical_model_t('solid', 3, ['x', 'y', 'z'], .false., .false., 6, [1, 2, 3, 4, 5, 6], &
    [character(4) :: 'xx', 'yy', 'zz', 'xy', 'yz', 'xz'])]

  real(rk), parameter :: pi = 3.14159265358979323846264338327950288_rk

contains

  !> Returns the row of the table with this name. If there is none, returns a row with an empty name and n_dim = 0.
  pure type(mechanical_model_t) function mechanical_model(name) result(model)
    character(*), intent(in) :: name
    integer :: i

    do i = 1, size(mechanical_models)
      if (mechanical_models(i)%name == name) model = mechanical_models(i)
    end do
  end function mechanical_model

  !> Returns the names that the coordinates have in expressions of the deck, such as r and z; shape (n_dim).
  pure function coordinate_names(model) result(names)
    type(mechanical_model_t), intent(in) :: model
    type(string_t), allocatable :: names(:)
    integer :: i

    allocate (names(0))
    do i = 1, model%n_dim
      call append_text(names, model%axes(i))
    end do
  end function coordinate_names

  !> Returns the factor of integrals over the mesh at a place: 2 pi r in axisymmetry, 1 elsewhere (in the plane per unit thickness).
  pure real(rk) function circumference(model, place)
    type(mechanical_model_t), intent(in) :: model
    !> [length] shape (n_dim)
    real(rk), intent(in) :: place(:)

    circumference = 1
    if (model%is_round) circumference = 2 * pi * place(1)
  end function circumference

  !> Whether the model is plane strain or plane stress: forces are then per unit thickness.
  pure logical function is_plane(model)
    type(mechanical_model_t), intent(in) :: model

    is_plane = model%n_dim == 2 .and. .not. model%is_round
  end function is_plane

  !> Returns a sentence without a full stop for messages: `a plane_strain model has the components x and y`, `an axisymmetric model
  !> has the components r and z`.
  pure function components_text(model) result(text)
    type(mechanical_model_t), intent(in) :: model
    character(:), allocatable :: text
    integer :: i

    text = 'a ' // trim(model%name)
    if (model%name(1:1) == 'a') text = 'an ' // trim(model%name)
    text = text // ' model has the components ' // model%axes(1)
    do i = 2, model%n_dim - 1
      text = text // ', ' // model%axes(i)
    end do
    text = text // ' and ' // model%axes(model%n_dim)
  end function components_text
end module sig_mechanical_models
