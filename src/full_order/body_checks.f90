! SPDX-License-Identifier: BSD-3-Clause
!> Whether prescribed displacements and contact together can hold every body, found from rigid motions before any solving.
module sig_body_checks
  use sig_bodies, only: regions_of_body
  use sig_deck_config, only: deck_config_t, name_config_t
  use sig_errors, only: error_t, make_error
  use sig_kinds, only: rk
  use sig_mechanical_models, only: mechanical_model, mechanical_model_t
  use sig_mesh, only: mesh_t
  use sig_motion_words, only: bodies_of_motions, motion_text, unheld_motions
  use sig_rigid_motions, only: rigid_motions_t
  use sig_text, only: append_text, join, string_t
  implicit none(type, external)
  private
  public :: body_name, check_bodies

contains

  !> Checks that prescribed displacements and contacts together can hold each body. A body with a rigid motion that only contact
  !> prevents gives a note. Errors: there is a rigid motion of one or more bodies that no prescribed displacement prevents and that
  !> changes the gap of no contact row; the message names the first of these bodies and its motion.
  subroutine check_bodies(deck, mesh, motions, notes, error)
    type(deck_config_t), intent(in) :: deck
    type(mesh_t), intent(in) :: mesh
    type(rigid_motions_t), intent(in) :: motions
    !> one per such body, empty after an error; sentences such as `only contact holds the body 'upper' (translation in y)`
    type(string_t), allocatable, intent(out) :: notes(:)
    type(error_t), allocatable, intent(out) :: error
    type(mechanical_model_t) :: model
    type(name_config_t) :: place
    real(rk), allocatable :: unheld(:, :), all_motions(:, :)
    integer, allocatable :: bodies(:)
    integer :: i

    model = mechanical_model(deck%mesh%model)
    allocate (notes(0))
    if (motions%n_free == 0) return
    unheld = unheld_motions(motions)
    bodies = bodies_of_motions(motions, unheld)
    if (size(bodies) > 0) then
      place = place_of_body(deck, mesh, motions, bodies(1))
      call make_error(error, 'nothing can hold the body ' // body_name(mesh, motions, bodies(1)) // ' (' // &
        motion_text(motions, unheld, bodies(1), model%axes) // '): neither a prescribed displacement nor a contact does', &
          deck%path, &
        place%line, place%column, 'prescribe a displacement that prevents this motion, on a boundary or at a Physical Point ' // &
        'of the mesh')
      return
    end if
    all_motions = identity(motions%n_free)
    bodies = bodies_of_motions(motions, all_motions)
    do i = 1, size(bodies)
      call append_text(notes, 'only contact holds the body ' // body_name(mesh, motions, bodies(i)) // ' (' // &
        motion_text(motions, all_motions, bodies(i), model%axes) // ')')
    end do
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
