! SPDX-License-Identifier: BSD-3-Clause
!> Whether prescribed displacements and contact together can hold every body, found from rigid motions before any solving.
module sig_body_checks
  use sig_bodies, only: regions_of_body
  use sig_deck_config, only: deck_config_t, name_config_t
  use sig_errors, only: error_t, make_error
  use sig_kinds, only: rk
  use sig_mechanical_models, only: mechanical_model, mechanical_model_t
  use sig_mesh, only: mesh_t
  use sig_motion_words, only: bodies_of_motions, held_amplitudes, motion_text
  use sig_rigid_motions, only: rigid_motions_t
  use sig_text, only: append_text, join, string_t
  implicit none(type, external)
  private
  public :: body_name, check_bodies

contains

  !> Finds what holds each body besides prescribed displacements. A body with a rigid motion that only contact prevents gives a
  !> note, and so does one with an idle motion, which nothing prevents. Errors: there is an idle motion, but the deck's
  !> solver.hold_unloaded_motions is false; the message names the first body that moves in it, and its motion.
  subroutine check_bodies(deck, mesh, motions, notes, error)
    type(deck_config_t), intent(in) :: deck
    type(mesh_t), intent(in) :: mesh
    type(rigid_motions_t), intent(in) :: motions
    !> one per such body, empty after an error; sentences such as `only contact holds the body 'upper' (translation in y)`
    type(string_t), allocatable, intent(out) :: notes(:)
    type(error_t), allocatable, intent(out) :: error
    type(mechanical_model_t) :: model
    type(name_config_t) :: place
    integer, allocatable :: bodies(:)
    integer :: i

    model = mechanical_model(deck%mesh%model)
    allocate (notes(0))
    do i = 1, motions%n_bodies
      if (.not. any(abs(motions%idle%amplitudes(:, i, :)) > 0)) cycle
      if (.not. deck%solver%holds_unloaded_motions) then
        place = place_of_body(deck, mesh, motions, i)
        call make_error(error, 'nothing can hold the body ' // named_motion(motions%idle%amplitudes(:, i, :)) // &
          ': neither a prescribed displacement nor a contact does', deck%path, place%line, place%column, 'prescribe a ' // &
          'displacement that prevents this motion, on a boundary or at a Physical Point of the mesh; or set ' // &
          'solver.hold_unloaded_motions to true, if no load drives it')
        return
      end if
      call append_text(notes, 'nothing holds the body ' // named_motion(motions%idle%amplitudes(:, i, :)) // &
        ', and no load drives it: its displacements are given without this motion')
    end do
    bodies = bodies_of_motions(motions, identity(motions%n_free))
    do i = 1, size(bodies)
      call append_text(notes, 'only contact holds the body ' // &
        named_motion(held_amplitudes(motions, bodies(i)), bodies(i)))
    end do

  contains

    !> Returns the name of body i, or of another one, with its motions: `'washer' (rotation about z)`.
    function named_motion(amplitudes, i_body) result(text)
      real(rk), intent(in) :: amplitudes(:, :)
      !> default: i
      integer, intent(in), optional :: i_body
      character(:), allocatable :: text
      integer :: number

      number = i
      if (present(i_body)) number = i_body
      text = body_name(mesh, motions, number) // ' (' // motion_text(motions, amplitudes, model%axes) // ')'
    end function named_motion
  end subroutine check_bodies

  !> Returns the names of a body's regions, `'upper', 'ring'`.
  pure function body_name(mesh, motions, i_body) result(text)
    type(mesh_t), intent(in) :: mesh
    type(rigid_motions_t), intent(in) :: motions
    !> 1-based
    integer, intent(in) :: i_body
    character(:), allocatable :: text

    text = '''' // join(regions_of_body(mesh, motions%body_of_node, i_body), ''', ''') // ''''
  end function body_name

  !> Returns where the deck's materials first name a region of the body: the name with its line and column.
  pure function place_of_body(deck, mesh, motions, i_body) result(place)
    type(deck_config_t), intent(in) :: deck
    type(mesh_t), intent(in) :: mesh
    type(rigid_motions_t), intent(in) :: motions
    !> 1-based
    integer, intent(in) :: i_body
    type(name_config_t) :: place
    type(string_t), allocatable :: regions(:)
    integer :: i, j, k

    regions = regions_of_body(mesh, motions%body_of_node, i_body)
    do i = 1, size(deck%materials)
      do j = 1, size(deck%materials(i)%regions)
        do k = 1, size(regions)
          if (deck%materials(i)%regions(j)%text /= regions(k)%text) cycle
          place = deck%materials(i)%regions(j)
          return
        end do
      end do
    end do
  end function place_of_body

  pure function identity(n) result(matrix)
    integer, intent(in) :: n
    real(rk) :: matrix(n, n)
    integer :: i

    matrix = 0
    do i = 1, n
      matrix(i, i) = 1
    end do
  end function identity
end module sig_body_checks
